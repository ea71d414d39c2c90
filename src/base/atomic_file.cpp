#include "deja_view/base/atomic_file.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/system_words.hpp"

#include <cerrno>
#include <fstream>

#include <fcntl.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

void FlushToDisk(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    ThrowInputError("{}: can't be reopened to flush: {}", path.string(), SystemsWords());
  }
  const int result = ::fsync(descriptor);
  ::close(descriptor);
  if (result != 0) {
    ThrowInputError("{}: can't be flushed to disk: {}", path.string(), SystemsWords());
  }
}

}  // namespace

void WriteFileAtomically(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  std::error_code error;
  if (path.has_parent_path()) {
    fs::create_directories(path.parent_path(), error);
    if (error) {
      ThrowInputError("{}: can't be written: {}", path.string(), error.message());
    }
  }
  const fs::path temporary = path.string() + ".tmp" + std::to_string(::getpid());
  try {
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    if (!stream) {
      ThrowInputError("{}: can't be written: {}", path.string(), SystemsWords());
    }
    write(stream);
    stream.close();
    if (!stream) {
      ThrowInputError("{}: can't be written: {}", path.string(), SystemsWords());
    }
    FlushToDisk(temporary);
    fs::rename(temporary, path);
  } catch (const fs::filesystem_error& e) {
    fs::remove(temporary, error);
    ThrowInputError("{}: can't be renamed into place: {}", path.string(), e.code().message());
  } catch (...) {
    fs::remove(temporary, error);
    throw;
  }
}

}  // namespace deja_view
