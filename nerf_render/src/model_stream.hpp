#pragma once

#include "deja_view/base/check.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <type_traits>

namespace deja_view::nerf::internal {

/// The container of a model file: see WriteField.
inline constexpr std::array<char, 8> kMagic = {'D', 'V', 'N', 'E', 'R', 'F', '\r', '\n'};
inline constexpr std::uint32_t kVersion = 2;
inline constexpr std::uint32_t kCellsVersion = 3;  // the same, and cells behind it
inline constexpr std::uint32_t kFrameVersion = 4;  // and a frame behind these

struct Header {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t reserved;
  std::uint64_t body_size;
};

/// FNV-1a over words of eight bytes, of data that comes in pieces.
class Checksum {
 public:
  void Add(const void* data, std::size_t size) {
    const char* from = static_cast<const char*>(data);
    for (; size > 0 && held_ > 0; --size) {
      Hold(*from++);
    }
    for (; size >= 8; size -= 8, from += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, from, 8);
      Mix(word);
    }
    for (; size > 0; --size) {
      Hold(*from++);
    }
  }
  std::uint64_t Value() const {
    Checksum last = *this;
    while (last.held_ > 0) {
      last.Hold(0);
    }
    return last.hash_;
  }

 private:
  void Hold(char byte) {
    word_[held_++] = byte;
    if (held_ == 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, word_.data(), 8);
      Mix(word);
      held_ = 0;
    }
  }
  void Mix(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0x100000001B3ULL;
    hash_ ^= hash_ >> 32U;
  }
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
  std::array<char, 8> word_{};
  std::size_t held_ = 0;
};

/// Counts bytes or, given a stream, writes and sums them up.
class Writer {
 public:
  explicit Writer(std::ostream* out) : out_(out) {}

  template <typename T>
  void Value(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    Bytes(&value, sizeof(T));
  }
  void Bytes(const void* from, std::size_t size) {
    size_ += size;
    if (out_ != nullptr && size > 0) {
      checksum_.Add(from, size);
      out_->write(static_cast<const char*>(from), static_cast<std::streamsize>(size));
    }
  }
  template <typename T>
  void operator()(const char* /*key*/, T& field) {
    if constexpr (std::is_arithmetic_v<T>) {
      Value(field);
    } else {
      field.Visit(*this);
    }
  }
  std::uint64_t size() const { return size_; }
  std::uint64_t checksum() const { return checksum_.Value(); }

 private:
  std::ostream* out_;
  std::uint64_t size_ = 0;
  Checksum checksum_;
};

/// Reads the body of a model file; what it says is to be believed only after Finish().
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path)
      : path_(path.string()), stream_(path, std::ios::binary | std::ios::ate) {
    if (!stream_) {
      ThrowInputError("{}: can't be opened as a NeRF model", path_);
    }
    const auto size = static_cast<std::uint64_t>(stream_.tellg());
    stream_.seekg(0);
    Header header{};
    char raw[sizeof(Header)];
    if (size < sizeof(Header) + 8 || !stream_.read(raw, sizeof(Header))) {
      ThrowInputError("{}: {} bytes are too few for a NeRF model", path_, size);
    }
    std::memcpy(&header, raw, sizeof(Header));
    if (header.magic != kMagic) {
      ThrowInputError("{}: is no NeRF model (its first bytes are others)", path_);
    }
    version_ = header.version;
    if (version_ < kVersion || version_ > kFrameVersion || header.reserved != 0) {
      ThrowInputError(
          "{}: version {}, expected {} to {}", path_, version_, kVersion, kFrameVersion);
    }
    left_ = size - sizeof(Header) - 8;
    if (header.body_size != left_) {
      ThrowInputError("{}: says {} bytes of content, has {}", path_, header.body_size, left_);
    }
  }

  template <typename T>
  T Value() {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_same_v<T, bool>) {
      const auto value = Value<std::uint8_t>();
      if (value > 1) {
        ThrowInputError("{}: a switch is {}, expected 0 or 1", path_, value);
      }
      return value == 1;
    } else {
      T value{};
      Bytes(&value, sizeof(T));
      return value;
    }
  }
  void Bytes(void* to, std::size_t size) {
    if (size > left_) {
      ThrowInputError("{}: ends early: {} more bytes expected, {} left", path_, size, left_);
    }
    if (size > 0) {
      if (!stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(size))) {
        ThrowInputError("{}: can't be read to its end", path_);
      }
      checksum_.Add(to, size);
      left_ -= size;
    }
  }
  template <typename T>
  void operator()(const char* /*key*/, T& field) {
    if constexpr (std::is_arithmetic_v<T>) {
      field = Value<T>();
    } else {
      field.Visit(*this);
    }
  }
  /// Throws InputError unless all has been read and was as it was written.
  void Finish() {
    if (left_ != 0) {
      ThrowInputError("{}: {} bytes too many", path_, left_);
    }
    std::uint64_t checksum = 0;
    char tail[sizeof(checksum)];
    if (!stream_.read(tail, sizeof(tail))) {
      ThrowInputError("{}: can't be read to its end", path_);
    }
    std::memcpy(&checksum, tail, sizeof(tail));
    if (checksum != checksum_.Value()) {
      ThrowInputError("{}: is damaged (its checksum differs)", path_);
    }
  }
  std::uint64_t left() const { return left_; }
  std::uint32_t version() const { return version_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::ifstream stream_;
  std::uint64_t left_ = 0;
  std::uint32_t version_ = 0;
  Checksum checksum_;
};

}  // namespace deja_view::nerf::internal
