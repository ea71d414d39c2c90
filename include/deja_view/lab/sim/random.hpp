#pragma once

#include <cmath>
#include <cstdint>

namespace deja_view::sim {

/// Random numbers whose bits do not depend on the standard library: SplitMix64 (Steele, Lea and
/// Flood, OOPSLA 2014). Independent streams of one seed keep one knob from changing everything
/// else.
class Rng {
 public:
  Rng(std::uint64_t seed, std::uint64_t stream)
      : state_(Mix(seed + 1) ^ Mix(stream * 0xd1342543de82ef95ULL + 0x632be59bd9b4e019ULL)) {}

  std::uint64_t Next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    return Mix(state_);
  }
  /// In [0, 1).
  double Uniform() { return static_cast<double>(Next() >> 11U) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// In [0, count).
  int Index(int count) { return static_cast<int>(Uniform() * count); }
  bool Chance(double probability) { return Uniform() < probability; }
  /// Standard normal (Box and Muller).
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(6.283185307179586 * Uniform());
  }

 private:
  static std::uint64_t Mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
  }

  std::uint64_t state_;
};

}  // namespace deja_view::sim
