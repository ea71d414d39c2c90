#pragma once

#include <cstddef>
#include <filesystem>

namespace deja_view::internal {

/// A file mapped read-only into memory. Empty when default constructed.
class MappedFile {
 public:
  MappedFile() = default;
  /// Throws InputError that names the path when it can't be opened or mapped or is empty.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;

  const void* data() const { return data_; }  ///< aligned to a page
  std::size_t size() const { return size_; }  ///< [byte]

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace deja_view::internal
