#include "deja_view/base/input_file.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/system_words.hpp"

#include <string>

#include <sys/stat.h>
#include <unistd.h>

namespace deja_view {
namespace {

const char* KindOf(mode_t mode) {
  if (S_ISDIR(mode)) {
    return "a directory";
  }
  return S_ISFIFO(mode) ? "a pipe" : "a device or socket";
}

}  // namespace

void CheckInputFile(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    ThrowInputError("{}: can't be opened: {}", path.string(), SystemsWords());
  }
  if (!S_ISREG(status.st_mode)) {
    ThrowInputError("{}: is {}: expected a file", path.string(), KindOf(status.st_mode));
  }
  if (::access(path.c_str(), R_OK) != 0) {
    ThrowInputError("{}: can't be opened: {}", path.string(), SystemsWords());
  }
}

std::ifstream OpenInputFile(const std::filesystem::path& path, std::ios::openmode mode) {
  CheckInputFile(path);
  errno = 0;
  std::ifstream stream(path, mode | std::ios::in);
  if (!stream) {
    ThrowInputError("{}: can't be opened: {}", path.string(), SystemsWords());
  }
  return stream;
}

}  // namespace deja_view
