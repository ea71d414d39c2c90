#include "deja_view/base/output_lock.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/base/temporary_file.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "file_identity.hpp"
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockName = ".deja_view_lock";

std::string ReadOwner(int descriptor) {
  std::array<char, 64> text{};
  const ssize_t size = ::pread(descriptor, text.data(), text.size(), 0);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "unknown";
}

void WriteOwner(int descriptor) {
  const std::string owner = std::to_string(::getpid());
  // Only told to others; the lock holds without.
  if (::ftruncate(descriptor, 0) == 0) {
    [[maybe_unused]] const ssize_t written = ::pwrite(descriptor, owner.data(), owner.size(), 0);
  }
}

// The process that had the lock before removes the file when it is done.
int Lock(const fs::path& output, const fs::path& lock_file) {
  while (true) {
    const int descriptor = ::open(lock_file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0) {
      ThrowInputError("{}: can't be written: {}: {}",
                      output.string(),
                      lock_file.string(),
                      std::strerror(errno));
    }
    const bool is_locked = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    if (!is_locked && errno == EWOULDBLOCK) {
      const std::string owner = ReadOwner(descriptor);
      ::close(descriptor);
      ThrowInputError(
          "{}: another process writes here (its number is {}): wait for it, or name "
          "another output",
          output.string(),
          Quote(owner));
    }
    if (!is_locked || internal::HasName(descriptor, lock_file)) {
      WriteOwner(descriptor);
      return descriptor;
    }
    ::close(descriptor);
  }
}

void MakeDirectories(const fs::path& directory, const fs::path& output) {
  std::error_code error;
  if (!directory.empty()) {
    fs::create_directories(directory, error);
  }
  if (error) {
    ThrowInputError("{}: can't be written: {}", output.string(), error.message());
  }
}

}  // namespace

OutputLock OutputLock::OfDirectory(const fs::path& directory) {
  MakeDirectories(directory, directory);
  OutputLock lock(directory, directory / kLockName);
  RemoveLeftovers(directory);
  return lock;
}

OutputLock OutputLock::OfFile(const fs::path& file) {
  MakeDirectories(file.parent_path(), file);
  return {file, file.string() + kLockName};
}

OutputLock::OutputLock(const fs::path& output, fs::path lock_file)
    : lock_file_(std::move(lock_file)), descriptor_(Lock(output, lock_file_)) {}

OutputLock::OutputLock(OutputLock&& other) noexcept
    : lock_file_(std::move(other.lock_file_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

OutputLock::~OutputLock() {
  if (descriptor_ >= 0) {
    ::unlink(lock_file_.c_str());
    ::close(descriptor_);
  }
}

}  // namespace deja_view
