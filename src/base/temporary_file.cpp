#include "deja_view/base/temporary_file.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
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

constexpr const char* kMark = ".deja_view_tmp";

bool IsTemporary(const std::string& name) {
  const std::size_t mark = name.rfind(kMark);
  if (mark == std::string::npos) {
    return false;
  }
  const std::string pid = name.substr(mark + std::strlen(kMark));
  return !pid.empty() && pid.find_first_not_of("0123456789") == std::string::npos;
}

// Where locks can't be had, a temporary is not known to be left over.
void RemoveIfLeft(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) {
    return;
  }
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) {
    ::unlink(path.c_str());
  }
  ::close(descriptor);
}

// Another process may take the file for left over between the two calls, and remove it.
int CreateLocked(const fs::path& path) {
  while (true) {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor < 0) {
      return descriptor;
    }
    if (::flock(descriptor, LOCK_EX) != 0 || internal::HasName(descriptor, path)) {
      return descriptor;
    }
    ::close(descriptor);
  }
}

template <typename Wanted>
void RemoveLeft(const fs::path& directory, const Wanted& is_wanted) {
  std::error_code error;
  for (fs::directory_iterator entry(directory.empty() ? "." : directory, error), end;
       !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::error_code ignored;
    if (is_wanted(name) && IsTemporary(name) &&
        fs::is_regular_file(entry->symlink_status(ignored))) {
      RemoveIfLeft(entry->path());
    }
  }
}

}  // namespace

TemporaryFile::TemporaryFile(fs::path target)
    : target_(std::move(target)), path_(target_.string() + kMark + std::to_string(::getpid())) {
  std::error_code error;
  if (target_.has_parent_path()) {
    fs::create_directories(target_.parent_path(), error);
    if (error) {
      ThrowInputError("{}: can't be written: {}", target_.string(), error.message());
    }
  }
  const std::string prefix = target_.filename().string() + kMark;
  RemoveLeft(target_.parent_path(),
             [&](const std::string& name) { return name.compare(0, prefix.size(), prefix) == 0; });
  descriptor_ = CreateLocked(path_);
  if (descriptor_ < 0) {
    Throw("can't be written");
  }
}

TemporaryFile::~TemporaryFile() {
  if (descriptor_ >= 0) {
    ::unlink(path_.c_str());
    ::close(descriptor_);
  }
}

void TemporaryFile::Rename() {
  if (::fsync(descriptor_) != 0) {
    Throw("can't be flushed to disk");
  }
  if (::rename(path_.c_str(), target_.c_str()) != 0) {
    Throw("can't be renamed into place");
  }
  ::close(std::exchange(descriptor_, -1));
}

void TemporaryFile::Throw(const char* what) const {
  ThrowInputError("{}: {}: {}", target_.string(), what, std::strerror(errno));
}

void RemoveLeftovers(const fs::path& directory) {
  RemoveLeft(directory, [](const std::string&) { return true; });
}

}  // namespace deja_view
