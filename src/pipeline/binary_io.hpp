#pragma once

#include "deja_view/base/check.hpp"

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

namespace deja_view {

/// Appends plain values to a byte string (little endian machines).
class BinaryWriter {
 public:
  template <typename T>
  void Write(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));  // NOLINT: raw bytes
  }
  template <typename T>
  void WriteAll(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    Write(static_cast<std::uint64_t>(values.size()));
    bytes_.append(reinterpret_cast<const char*>(values.data()),  // NOLINT: raw bytes
                  values.size() * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads them back; throws InputError that names the source and the field for a buffer that is too
/// short.
class BinaryReader {
 public:
  BinaryReader(const std::string& bytes, std::string source)
      : bytes_(bytes), source_(std::move(source)) {}

  template <typename T>
  T Read(const char* field) {
    static_assert(std::is_trivially_copyable_v<T>);
    Require(sizeof(T), field);
    T value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }
  template <typename T>
  std::vector<T> ReadAll(const char* field) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto count = Read<std::uint64_t>(field);
    if (count > (bytes_.size() - position_) / sizeof(T)) {
      Fail(field, "more entries than the file has room for");
    }
    std::vector<T> values(count);
    if (count > 0) {
      std::memcpy(static_cast<void*>(values.data()), bytes_.data() + position_, count * sizeof(T));
    }
    position_ += count * sizeof(T);
    return values;
  }
  bool AtEnd() const { return position_ == bytes_.size(); }

  [[noreturn]] void Fail(const char* field, const char* what) const {
    ThrowInputError("{}: {}: {} (at byte {})", source_, field, what, position_);
  }

 private:
  void Require(std::size_t count, const char* field) const {
    if (bytes_.size() - position_ < count) {
      Fail(field, "the file ends too early");
    }
  }

  const std::string& bytes_;
  std::string source_;
  std::size_t position_ = 0;
};

}  // namespace deja_view
