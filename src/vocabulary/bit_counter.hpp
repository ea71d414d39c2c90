#pragma once

#include "deja_view/features/types.hpp"

#include <array>
#include <cstdint>
#include <cstring>

namespace deja_view::internal {

// Bit i of a byte goes to byte i of a word.
constexpr std::array<std::uint64_t, 256> MakeBitSpread() {
  std::array<std::uint64_t, 256> spread{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      spread[byte] |= std::uint64_t{(byte >> bit) & 1U} << (8 * bit);
    }
  }
  return spread;
}
inline constexpr std::array<std::uint64_t, 256> kBitSpread = MakeBitSpread();

/// Counts, for each of the 256 bits, in how many descriptors it is set.
class BitCounter {
 public:
  void Add(const Descriptor& descriptor) {
    // Eight counters of eight bits in each of 32 words; spread into 32-bit ones before they
    // overflow.
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(descriptor.words.data());
    for (std::size_t i = 0; i < small_.size(); ++i) {
      small_[i] += kBitSpread[bytes[i]];
    }
    if (++pending_ == 255) {
      Flush();
    }
    ++count_;
  }

  void Add(BitCounter other) {
    Flush();
    other.Flush();
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      counts_[i] += other.counts_[i];
    }
    count_ += other.count_;
  }

  std::uint64_t count() const { return count_; }

  /// The bits set in at least half of the descriptors.
  Descriptor Majority() {
    Flush();
    Descriptor majority;
    auto* bytes = reinterpret_cast<std::uint8_t*>(majority.words.data());
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const bool is_set = 2 * counts_[i] >= count_;
      bytes[i / 8] = static_cast<std::uint8_t>(bytes[i / 8] | (is_set ? 1U << (i % 8) : 0U));
    }
    return majority;
  }

 private:
  void Flush() {
    for (std::size_t i = 0; i < small_.size(); ++i) {
      for (std::size_t bit = 0; bit < 8; ++bit) {
        counts_[8 * i + bit] += small_[i] >> (8 * bit) & 0xffU;
      }
      small_[i] = 0;
    }
    pending_ = 0;
  }

  std::array<std::uint64_t, 32> small_{};
  std::array<std::uint64_t, 256> counts_{};
  int pending_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace deja_view::internal
