#pragma once

#include <filesystem>

namespace deja_view {

/// A file that gets its name when it is complete: `target`.deja_view_tmpPID until then. While the
/// process lives it holds a lock on the temporary, so that what a killed one left can be told from
/// what is being written.
class TemporaryFile {
 public:
  /// Creates the temporary, and missing parent directories; removes what killed processes left of
  /// the same target. Throws InputError that names the target.
  explicit TemporaryFile(std::filesystem::path target);
  /// Removes the temporary unless it was renamed.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Empty; to be opened and written by this name.
  const std::filesystem::path& path() const { return path_; }

  /// Flushes what was written to disk and gives it the target's name. Throws InputError that names
  /// the target.
  void Rename();

 private:
  [[noreturn]] void Throw(const char* what) const;

  std::filesystem::path target_;
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Removes the temporaries that killed processes left in a directory: files with the names above
/// that no living process holds. Nothing when it can't be read.
void RemoveLeftovers(const std::filesystem::path& directory);

}  // namespace deja_view
