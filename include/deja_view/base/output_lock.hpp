#pragma once

#include <filesystem>

namespace deja_view {

/// Keeps other processes away from an output while this one writes it: a lock file in a directory,
/// or beside a file. A killed process's lock ends with it. Where the file system knows no locks,
/// nothing is kept away.
class OutputLock {
 public:
  /// Also removes what killed processes left there (RemoveLeftovers). Throws InputError that names
  /// the output and the process that has it, or why the lock file can't be made.
  static OutputLock OfDirectory(const std::filesystem::path& directory);
  static OutputLock OfFile(const std::filesystem::path& file);

  ~OutputLock();
  OutputLock(OutputLock&& other) noexcept;
  OutputLock& operator=(OutputLock&& other) = delete;
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;

 private:
  OutputLock(const std::filesystem::path& output, std::filesystem::path lock_file);

  std::filesystem::path lock_file_;
  int descriptor_ = -1;
};

}  // namespace deja_view
