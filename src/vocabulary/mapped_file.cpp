#include "mapped_file.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/system_words.hpp"

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace deja_view::internal {

MappedFile::MappedFile(const std::filesystem::path& path) {
  CheckInputFile(path);
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    ThrowInputError("{}: can't be opened: {}", path.string(), SystemsWords());
  }
  struct stat status {};
  int error = ::fstat(file, &status) == 0 ? 0 : errno;
  if (error == 0 && !S_ISREG(status.st_mode)) {
    error = EISDIR;
  }
  if (error == 0 && status.st_size > 0) {
    size_ = static_cast<std::size_t>(status.st_size);
    data_ = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    error = data_ != MAP_FAILED ? 0 : errno;
  }
  ::close(file);
  if (error != 0) {
    data_ = nullptr;
    ThrowInputError("{}: can't be mapped into memory: {}", path.string(), SystemsWords(error));
  }
  if (size_ == 0) {
    ThrowInputError("{}: is empty", path.string());
  }
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) {
    ::munmap(data_, size_);
  }
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

}  // namespace deja_view::internal
