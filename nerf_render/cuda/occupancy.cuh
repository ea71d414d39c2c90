#pragma once

#include "deja_view/base/random.hpp"

#include <algorithm>

#include "field_views.cuh"
#include "occupancy_rule.hpp"

// The occupancy grid's upkeep; what OccupancyUpdate does.

namespace deja_view::nerf::internal {

/// What both passes over cells need.
struct CellRule {
  OccupancyView grid;
  const std::uint64_t* open = nullptr;  ///< per block: cells that may hold matter
  std::uint64_t seed = 0;
  std::uint64_t round = 0;
  bool full = false;

  /// Moves `random` to the cell's numbers; the first says whether it is due.
  DEJA_VIEW_HOST_DEVICE bool IsDue(std::size_t cell, Random* random) const {
    constexpr std::uint64_t kNumbersPerCell = 4;
    *random = Random(seed, (round << 32U) + cell / 64);
    random->Skip(kNumbersPerCell * (cell % 64));
    const bool is_drawn = (random->Next() >> 60U) == 0;
    return (is_drawn || grid.IsOccupied(cell) || full) &&
           (open[cell / 64] >> (cell % 64) & 1U) != 0;
  }
};

/// Index: cell. The decaying maximum of its density, seen at a random place.
template <std::size_t kInputs>
struct LookIntoCell {
  CellRule rule;
  DensityView field;
  std::array<float, 3> extent{};
  float* density = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t cell) const {
    Random random(0);
    if (!rule.IsDue(cell, &random)) {
      return;
    }
    const float size = 1 / rule.grid.scale;
    const std::array<int, 3> at = rule.grid.Cell(cell);
    std::array<float, 3> p{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float u = random.UniformFloat();
      p[axis] = std::min(extent[axis], (static_cast<float>(at[axis]) + u) * size);
    }
    const float sigma = DensityOf(field.template LogDensity<kInputs>(p));
    density[cell] = std::max(kOccupancyDecay * density[cell], sigma);
  }
};

/// Index: block. Which of its cells are occupied.
struct MarkBlock {
  CellRule rule;
  const float* density = nullptr;
  float threshold = 0;
  std::uint64_t* words = nullptr;  ///< not those of the rule

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t block) const {
    std::uint64_t word = rule.grid.words[block];
    for (std::size_t i = 0; i < 64 && rule.open[block] != 0; ++i) {
      const std::uint64_t bit = std::uint64_t{1} << i;
      Random random(0);
      if (rule.IsDue(64 * block + i, &random)) {
        word = density[64 * block + i] > threshold ? word | bit : word & ~bit;
      }
    }
    words[block] = word;
  }
};

/// Index: block. Sum of the open cells' densities.
struct SumBlock {
  const std::uint64_t* open = nullptr;
  const float* density = nullptr;
  double* sums = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t block) const {
    double sum = 0;
    for (std::size_t i = 0; i < 64; ++i) {
      if ((open[block] >> i & 1U) != 0) {
        sum += static_cast<double>(density[64 * block + i]);
      }
    }
    sums[block] = sum;
  }
};

/// Index: block. 0 where it holds matter, or else farther than any leap.
struct StartLeaps {
  static constexpr std::uint8_t kFarthest = 15;

  const std::uint64_t* words = nullptr;
  std::uint8_t* leaps = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t block) const {
    leaps[block] = words[block] == 0 ? kFarthest : std::uint8_t{0};
  }
};

/// Index: block. The largest difference of coordinates to a block with matter, extended to one more
/// axis, along which blocks are `stride` apart.
struct SpreadLeaps {
  std::size_t count = 1;  ///< of blocks along the axis
  std::size_t stride = 1;
  const std::uint8_t* in = nullptr;
  std::uint8_t* out = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t block) const {
    constexpr std::size_t kReach = StartLeaps::kFarthest;
    const std::size_t i = block / stride % count;
    const std::size_t line = block - i * stride;
    std::uint8_t least = in[block];
    for (std::size_t j = i - std::min(i, kReach); j <= std::min(count - 1, i + kReach); ++j) {
      const auto apart = static_cast<std::uint8_t>(i > j ? i - j : j - i);
      least = std::min(least, std::max(apart, in[line + j * stride]));
    }
    out[block] = least;
  }
};

}  // namespace deja_view::nerf::internal
