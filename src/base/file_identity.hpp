#pragma once

#include <filesystem>

#include <sys/stat.h>

namespace deja_view::internal {

/// Whether an open file still has this name: another process may have removed it.
inline bool HasName(int descriptor, const std::filesystem::path& path) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace deja_view::internal
