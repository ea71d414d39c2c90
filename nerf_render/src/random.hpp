#pragma once

#include <cstdint>

namespace deja_view::nerf::internal {

/// A counter-based generator (splitmix64, Steele et al., OOPSLA 2014): the same numbers for the
/// same (seed, stream, counter) on any thread.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) : state_(Mix(seed + Mix(stream))) {}

  std::uint64_t Next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    return Mix(state_);
  }
  /// In [0, 1).
  float Uniform() { return static_cast<float>(Next() >> 40U) * 0x1p-24F; }
  /// In [0, count).
  std::uint32_t Index(std::uint32_t count) {
    return static_cast<std::uint32_t>((Next() >> 32U) * count >> 32U);
  }

 private:
  static std::uint64_t Mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }
  std::uint64_t state_;
};

}  // namespace deja_view::nerf::internal
