#include "deja_view/base/hash.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"

#include <array>
#include <fstream>

#include <xxhash.h>

namespace deja_view {

std::uint64_t Hash64(const void* data, std::size_t size) {
  return XXH64(data, size, 0);
}

std::uint64_t Hash64(std::string_view text) {
  return Hash64(text.data(), text.size());
}

struct Hasher64::State {
  struct Free {
    void operator()(XXH64_state_t* state) const { XXH64_freeState(state); }
  };
  std::unique_ptr<XXH64_state_t, Free> xxh{XXH64_createState()};
};

Hasher64::Hasher64() : state_(std::make_unique<State>()) {
  DEJA_VIEW_CHECK(state_->xxh != nullptr && XXH64_reset(state_->xxh.get(), 0) == XXH_OK);
}

Hasher64::~Hasher64() = default;
Hasher64::Hasher64(Hasher64&&) noexcept = default;
Hasher64& Hasher64::operator=(Hasher64&&) noexcept = default;

void Hasher64::Add(const void* data, std::size_t size) {
  if (size > 0) {
    DEJA_VIEW_CHECK(XXH64_update(state_->xxh.get(), data, size) == XXH_OK);
  }
}

std::uint64_t Hasher64::value() const {
  return XXH64_digest(state_->xxh.get());
}

std::uint64_t Hash64OfFile(const std::filesystem::path& path) {
  std::ifstream in = OpenInputFile(path, std::ios::binary);
  Hasher64 hasher;
  std::array<char, 1 << 16> block{};
  while (in.read(block.data(), block.size()) || in.gcount() > 0) {
    hasher.Add(block.data(), static_cast<std::size_t>(in.gcount()));
  }
  return hasher.value();
}

}  // namespace deja_view
