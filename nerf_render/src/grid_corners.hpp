#pragma once

#include "deja_view/base/host_device.hpp"
#include "deja_view/nerf/kernel_table.hpp"

#include <array>
#include <cstdint>

namespace deja_view::nerf::internal {

/// The eight corners of the cell that holds a position; corner c lies at bit 0 of c along x, bit 1
/// along y, bit 2 along z.
struct Corners {
  std::array<std::uint32_t, 8> entry;
  std::array<float, 8> weight;
  std::array<float, 3> fraction;  ///< of the way through the cell
};

DEJA_VIEW_HOST_DEVICE inline Corners FindCorners(const GridLevel& level,
                                                 float x,
                                                 float y,
                                                 float z) {
  const std::array<float, 3> p = {x * level.scale, y * level.scale, z * level.scale};
  std::array<std::uint32_t, 3> cell{};
  Corners corners{};
  std::array<float, 3>& fraction = corners.fraction;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<std::uint32_t>(p[axis]);
    fraction[axis] = p[axis] - static_cast<float>(cell[axis]);
  }
  for (std::uint32_t c = 0; c < 8; ++c) {
    const std::uint32_t i = cell[0] + (c & 1U);
    const std::uint32_t j = cell[1] + (c >> 1U & 1U);
    const std::uint32_t k = cell[2] + (c >> 2U);
    const std::uint32_t a = i >> 1U;
    const std::uint32_t b = j >> 1U;
    const std::uint32_t d = k >> 1U;
    const std::uint32_t brick = level.hashed ? (a ^ b * 2654435761U ^ d * 805459861U) & level.mask
                                             : a + b * level.stride_y + d * level.stride_z;
    corners.entry[c] = brick * 8 + (i & 1U) + (j & 1U) * 2 + (k & 1U) * 4;
    corners.weight[c] = ((c & 1U) != 0 ? fraction[0] : 1 - fraction[0]) *
                        ((c & 2U) != 0 ? fraction[1] : 1 - fraction[1]) *
                        ((c & 4U) != 0 ? fraction[2] : 1 - fraction[2]);
  }
  return corners;
}

}  // namespace deja_view::nerf::internal
