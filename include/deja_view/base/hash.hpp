#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

namespace deja_view {

/// XXH64 with seed 0: tells damaged files and other settings, the same on every machine; no defence
/// against an adversary.
std::uint64_t Hash64(const void* data, std::size_t size);
std::uint64_t Hash64(std::string_view text);

/// Hash64 of data that comes in pieces.
class Hasher64 {
 public:
  Hasher64();
  ~Hasher64();
  Hasher64(Hasher64&& other) noexcept;
  Hasher64& operator=(Hasher64&& other) noexcept;

  void Add(const void* data, std::size_t size);
  /// Of all that was added so far.
  std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Hash64 of a file's bytes. Throws InputError that names it.
std::uint64_t Hash64OfFile(const std::filesystem::path& path);

}  // namespace deja_view
