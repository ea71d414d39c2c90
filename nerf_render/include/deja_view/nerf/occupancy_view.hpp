#pragma once

#include "deja_view/base/host_device.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace deja_view::nerf {

/// What a ray asks of an OccupancyGrid, in plain numbers: for CPU and card alike.
struct OccupancyView {
  std::array<int, 3> cells{};            ///< per axis, multiples of 4
  std::array<int, 3> blocks{};           ///< of 4x4x4 cells
  float scale = 1;                       ///< cells per unit length
  const std::uint64_t* words = nullptr;  ///< per block, a bit per cell
  const std::uint8_t* leaps = nullptr;   ///< per block: OccupancyGrid::leap

  /// Index of a cell: 64 block + place in the block.
  DEJA_VIEW_HOST_DEVICE std::size_t Index(int x, int y, int z) const {
    const int block = (z >> 2) * blocks[1] * blocks[0] + (y >> 2) * blocks[0] + (x >> 2);
    const int place = (z & 3) * 16 + (y & 3) * 4 + (x & 3);
    return static_cast<std::size_t>(block) * 64 + static_cast<std::size_t>(place);
  }
  /// Coordinates of a cell's lowest corner, in cells.
  DEJA_VIEW_HOST_DEVICE std::array<int, 3> Cell(std::size_t index) const {
    const auto block = static_cast<int>(index / 64);
    const auto place = static_cast<int>(index % 64);
    return {4 * (block % blocks[0]) + place % 4,
            4 * (block / blocks[0] % blocks[1]) + place / 4 % 4,
            4 * (block / (blocks[0] * blocks[1])) + place / 16};
  }
  DEJA_VIEW_HOST_DEVICE bool IsOccupied(std::size_t index) const {
    return (words[index / 64] >> (index % 64) & 1U) != 0;
  }
};

}  // namespace deja_view::nerf
