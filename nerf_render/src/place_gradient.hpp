#pragma once

#include "deja_view/base/host_device.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

#include "grid_corners.hpp"
#include "ray_march.hpp"

namespace deja_view::nerf::internal {

/// Derivative of the loss by a camera's pose through one ray: by a shift of the camera in unit
/// lengths along N's axes, then by a rotation vector [rad] about N's axes through the camera.
using PoseGradient = std::array<float, 6>;

/// Adds to *d_place what a level's interpolation passes on from d_level, the derivatives of its
/// features at the place (x, y, z).
DEJA_VIEW_HOST_DEVICE inline void AddSlopes(const GridLevel& level,
                                            const float* table,
                                            const std::array<float, 3>& place,
                                            const float* d_level,
                                            std::array<float, 3>* d_place) {
  const auto features = static_cast<std::size_t>(level.features);
  const Corners corners = FindCorners(level, place[0], place[1], place[2]);
  for (std::uint32_t c = 0; c < 8; ++c) {
    float value = 0;
    for (std::size_t f = 0; f < features; ++f) {
      value += table[corners.entry[c] * features + f] * d_level[f];
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float slope = (c >> axis & 1U) != 0 ? level.scale : -level.scale;
      for (std::size_t other = 0; other < 3; ++other) {
        if (other != axis) {
          const float fraction = corners.fraction[other];
          slope *= (c >> other & 1U) != 0 ? fraction : 1 - fraction;
        }
      }
      (*d_place)[axis] += slope * value;
    }
  }
}

/// Adds what a sample at length t, whose place has the derivative g, passes on to its camera's
/// pose: p = origin + t direction, and a rotation w moves it by w x (t direction).
DEJA_VIEW_HOST_DEVICE inline void AddToPose(const Ray& ray,
                                            float t,
                                            const std::array<float, 3>& g,
                                            PoseGradient* pose) {
  const std::array<float, 3>& d = ray.direction;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t next = (axis + 1) % 3;
    const std::size_t last = (axis + 2) % 3;
    (*pose)[axis] += g[axis];
    (*pose)[3 + axis] += t * (d[next] * g[last] - d[last] * g[next]);
  }
}

}  // namespace deja_view::nerf::internal
