#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace deja_view {

/// 256-bit binary descriptor; bit i is bit i % 64 of word i / 64 (VINS-Mono's and DBoW2's order for
/// BRIEF). An OpenCV descriptor row of 32 bytes is the same memory on a little-endian machine.
struct alignas(32) Descriptor {
  std::array<std::uint64_t, 4> words{};

  friend bool operator==(const Descriptor& a, const Descriptor& b) { return a.words == b.words; }
  friend bool operator!=(const Descriptor& a, const Descriptor& b) { return !(a == b); }
};
static_assert(sizeof(Descriptor) == 32, "a descriptor is 32 bytes in files and in memory maps");

/// Number of bits in which two descriptors differ, 0 to 256.
inline int HammingDistance(const Descriptor& a, const Descriptor& b) {
#if defined(__x86_64__) && !defined(__POPCNT__)
  // Without the instruction the compiler would call a function per word: bits are counted in ever
  // wider fields, of two words together as soon as a field holds their sum.
  constexpr std::uint64_t kPairs = 0x5555555555555555;
  constexpr std::uint64_t kNibbles = 0x3333333333333333;
  constexpr std::uint64_t kBytes = 0x0F0F0F0F0F0F0F0F;
  constexpr std::uint64_t kSumOfBytes = 0x0101010101010101;
  const auto nibbles = [&](std::size_t i) {
    std::uint64_t x = a.words[i] ^ b.words[i];
    x -= (x >> 1U) & kPairs;
    return (x & kNibbles) + ((x >> 2U) & kNibbles);
  };
  const auto two = [&](std::size_t i) {
    const std::uint64_t sum = nibbles(i) + nibbles(i + 1);
    return ((sum & kBytes) + ((sum >> 4U) & kBytes)) * kSumOfBytes >> 56U;
  };
  return static_cast<int>(two(0) + two(2));
#else
  int distance = 0;
  for (std::size_t i = 0; i < a.words.size(); ++i) {
    distance += __builtin_popcountll(a.words[i] ^ b.words[i]);
  }
  return distance;
#endif
}

/// Corner in the full-resolution image; (0, 0) is the centre of the top left pixel.
struct Keypoint {
  float x = 0;         ///< [px]
  float y = 0;         ///< [px]
  float response = 0;  ///< corner score, comparable within one image
  float angle = 0;     ///< [rad], clockwise in the image, by which the patch was turned
  std::int32_t octave = 0;
};

/// What is extracted from one image: descriptors[i] belongs to keypoints[i].
struct Features {
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
};

}  // namespace deja_view
