#pragma once

#include "deja_view/base/host_device.hpp"

#include <cstdint>

namespace deja_view {

/// Random numbers whose bits do not depend on the standard library or the thread: SplitMix64
/// (Steele, Lea and Flood, OOPSLA 2014).
class Random {
 public:
  DEJA_VIEW_HOST_DEVICE explicit Random(std::uint64_t seed) : state_(seed) {}
  /// Independent streams of one seed: one more draw in one of them changes none of the others.
  DEJA_VIEW_HOST_DEVICE Random(std::uint64_t seed, std::uint64_t stream)
      : state_(Mix(seed + Mix(stream))) {}

  DEJA_VIEW_HOST_DEVICE std::uint64_t Next() {
    state_ += kIncrement;
    return Mix(state_);
  }
  /// As if `draws` numbers had been drawn: whoever knows where its own begin need not wait.
  DEJA_VIEW_HOST_DEVICE void Skip(std::uint64_t draws) { state_ += draws * kIncrement; }
  /// In [0, 1).
  DEJA_VIEW_HOST_DEVICE double Uniform() { return static_cast<double>(Next() >> 11U) * 0x1p-53; }
  /// In [low, high).
  DEJA_VIEW_HOST_DEVICE double Uniform(double low, double high) {
    return low + (high - low) * Uniform();
  }
  /// In [0, 1).
  DEJA_VIEW_HOST_DEVICE float UniformFloat() {
    return static_cast<float>(Next() >> 40U) * 0x1p-24F;
  }
  /// In [0, limit), limit > 0; the bias is below limit / 2^64.
  DEJA_VIEW_HOST_DEVICE std::uint64_t Below(std::uint64_t limit) { return Next() % limit; }
  /// In [0, count), without a division.
  DEJA_VIEW_HOST_DEVICE std::uint32_t Index(std::uint32_t count) {
    return static_cast<std::uint32_t>((Next() >> 32U) * count >> 32U);
  }

  /// Spreads every bit of z over all of the result.
  DEJA_VIEW_HOST_DEVICE static std::uint64_t Mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }

 private:
  static constexpr std::uint64_t kIncrement = 0x9e3779b97f4a7c15U;

  std::uint64_t state_;
};

}  // namespace deja_view
