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
  int distance = 0;
  for (std::size_t i = 0; i < a.words.size(); ++i) {
    distance += __builtin_popcountll(a.words[i] ^ b.words[i]);
  }
  return distance;
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
