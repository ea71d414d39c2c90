#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace deja_view {

/// Kind of a binary file. All of ours are, little endian:
///   8 bytes magic, uint32 version, uint32 0, uint64 length of the body, body, uint64 Hash64 of the
///   body
struct BinaryFormat {
  std::array<char, 8> magic;
  std::uint32_t version;
  const char* what;                ///< "a saved map", for messages
  std::uint32_t oldest = version;  ///< version that can still be read
};

/// Writes the body of a binary file; also a visitor of structs with Visit.
class BinaryWriter {
 public:
  explicit BinaryWriter(std::ostream* out) : out_(out) {}

  template <typename T>
  void Write(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    WriteBytes(&value, sizeof(T));
  }
  /// A uint64 count and the values of a container in one piece.
  template <typename Values>
  void WriteAll(const Values& values) {
    using T = std::remove_cv_t<std::remove_pointer_t<decltype(values.data())>>;
    static_assert(std::is_trivially_copyable_v<T>);
    Write(static_cast<std::uint64_t>(values.size()));
    WriteBytes(values.data(), static_cast<std::size_t>(values.size()) * sizeof(T));
  }
  void WriteBytes(const void* from, std::size_t size);

  template <typename T>
  void operator()(const char* /*key*/, T& field) {
    if constexpr (std::is_arithmetic_v<T>) {
      Write(field);
    } else {
      field.Visit(*this);
    }
  }
  std::uint64_t size() const { return size_; }
  std::uint64_t hash() const { return hasher_.value(); }

 private:
  std::ostream* out_;
  std::uint64_t size_ = 0;
  Hasher64 hasher_;
};

/// Writes a file, whole or not at all (WriteFileAtomically).
void WriteBinaryFile(const std::filesystem::path& path,
                     const BinaryFormat& format,
                     const std::function<void(BinaryWriter*)>& write_body);

/// Reads the body of a binary file; also a visitor of structs with Visit. Errors are InputErrors
/// that name the path and the field; nothing is allocated beyond what the file's length covers.
class BinaryReader {
 public:
  /// Throws for a file that is missing, of another kind or version, cut off, longer than it says,
  /// or damaged.
  BinaryReader(const std::filesystem::path& path, const BinaryFormat& format);

  template <typename T>
  T Read(const char* field) {
    static_assert(std::is_trivially_copyable_v<T>);
    if constexpr (std::is_same_v<T, bool>) {
      const auto value = Read<std::uint8_t>(field);
      if (value > 1) {
        Fail(field, "a switch that is neither 0 nor 1");
      }
      return value == 1;
    } else {
      T value{};
      ReadBytes(&value, sizeof(T), field);
      return value;
    }
  }
  /// What WriteAll wrote, of any length.
  template <typename T>
  std::vector<T> ReadAll(const char* field) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto count = Read<std::uint64_t>(field);
    if (count > left_ / sizeof(T)) {
      Fail(field, "more entries than the file has room for");
    }
    std::vector<T> values(count);
    ReadBytes(values.data(), count * sizeof(T), field);
    return values;
  }
  void ReadBytes(void* to, std::size_t size, const char* field);

  template <typename T>
  void operator()(const char* key, T& field) {
    if constexpr (std::is_arithmetic_v<T>) {
      field = Read<T>(key);
    } else {
      field.Visit(*this);
    }
  }
  /// Throws unless all has been read.
  void Finish() const;
  [[noreturn]] void Fail(const char* field, std::string_view what) const;

  /// Passes over bytes of the body.
  void Skip(std::uint64_t size, const char* field);

  /// Bytes of the body that have not been read.
  std::uint64_t left() const { return left_; }
  std::uint32_t version() const { return version_; }
  const std::string& path() const { return path_; }

 private:
  void CheckHash();

  std::string path_;
  std::ifstream stream_;
  std::uint32_t version_ = 0;
  std::uint64_t size_ = 0;
  std::uint64_t left_ = 0;
};

}  // namespace deja_view
