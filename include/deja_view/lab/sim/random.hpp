#pragma once

#include "deja_view/base/angles.hpp"
#include "deja_view/base/random.hpp"

#include <cmath>
#include <cstdint>

namespace deja_view::sim {

/// What a simulation draws. Independent streams of one seed keep one knob from changing everything
/// else; they are not those of Random, so that worlds of earlier versions stay as they are.
class Rng : public Random {
 public:
  Rng(std::uint64_t seed, std::uint64_t stream)
      : Random(Mix(seed + 1) ^ Mix(stream * 0xd1342543de82ef95ULL + 0x632be59bd9b4e019ULL)) {}

  /// In [0, count).
  int Index(int count) { return static_cast<int>(Uniform() * count); }
  bool Chance(double probability) { return Uniform() < probability; }
  /// Standard normal (Box and Muller).
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2 * kPi * Uniform());
  }
};

}  // namespace deja_view::sim
