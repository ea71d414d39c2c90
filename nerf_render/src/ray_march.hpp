#pragma once

#include "deja_view/base/host_device.hpp"
#include "deja_view/nerf/occupancy_view.hpp"
#include "deja_view/nerf/options.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace deja_view::nerf::internal {

/// A field's box in plain numbers.
struct BoxView {
  std::array<double, 3> min{};     ///< in N [m]
  double size = 1;                 ///< longest side [m]
  std::array<double, 3> extent{};  ///< in unit lengths
};

/// A ray in unit coordinates, from where it enters the box, or begins within: so its lengths are at
/// most the box's diagonal, which keeps them exact however far the camera is. `direction` is a unit
/// vector.
struct Ray {
  std::array<float, 3> origin{};
  std::array<float, 3> direction{};
  std::array<float, 3> inverse{};  ///< of the direction; 0: along this axis' faces
  float before = 0;                ///< length from the camera to the origin
  float end = 0;                   ///< length to where it leaves the box; <= 0: it misses
  float jitter = 0.5F;             ///< place of the samples within their steps, in [0, 1)
  const float* latent = nullptr;   ///< of its image; null: zeros
};

/// How a field is sampled in one pass.
struct TraceOptions {
  MarchOptions march;
  float step_factor = 1;  ///< of all steps; coarse ones warm a field up
};

/// A sample on a ray; lengths from the ray's origin.
struct MarchSample {
  float middle = 0;
  float dt = 0;
};

constexpr std::size_t kSamplesPerRound = 4;  ///< of a ray, whose densities are asked for together
constexpr float kNudge = 1e-6F;              ///< beyond a face, in unit lengths

/// The ray of `origin_N` [m] and unit vector `direction_N` through the box.
DEJA_VIEW_HOST_DEVICE inline Ray RayInBox(const BoxView& box,
                                          const double* origin_N,
                                          const double* direction_N,
                                          float jitter) {
  constexpr double kLeastSlope = 1e-6;  // below, rounding moves a crossing more than the ray does
  Ray ray;
  ray.jitter = jitter;
  std::array<double, 3> origin{};
  double begin = 0;
  double end = std::numeric_limits<double>::max();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d = direction_N[axis];
    origin[axis] = (origin_N[axis] - box.min[axis]) / box.size;
    ray.direction[axis] = static_cast<float>(d);
    ray.inverse[axis] = std::abs(d) > kLeastSlope ? static_cast<float>(1 / d) : 0.0F;
    if (std::abs(d) < 1e-12) {
      if (origin[axis] < 0 || origin[axis] > box.extent[axis]) {
        end = -1;
      }
      continue;
    }
    const double a = -origin[axis] / d;
    const double b = (box.extent[axis] - origin[axis]) / d;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.origin[axis] = static_cast<float>(origin[axis] + begin * direction_N[axis]);
  }
  ray.before = static_cast<float>(begin);
  ray.end = end > begin ? static_cast<float>(end - begin) : 0.0F;
  return ray;
}

/// Length to where the ray leaves the cube [low, low + size] of cells.
DEJA_VIEW_HOST_DEVICE inline float ExitOf(const Ray& ray,
                                          const std::array<int, 3>& low,
                                          int size,
                                          float cell) {
  float exit = std::numeric_limits<float>::max();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (ray.inverse[axis] != 0) {
      const int face = low[axis] + (ray.inverse[axis] > 0 ? size : 0);
      exit =
          std::min(exit, (static_cast<float>(face) * cell - ray.origin[axis]) * ray.inverse[axis]);
    }
  }
  return exit;
}

/// Length to where the ray leaves the empty cells about the empty cell `at`.
DEJA_VIEW_HOST_DEVICE inline float LeapOver(const OccupancyView& grid,
                                            std::size_t index,
                                            const std::array<int, 3>& at,
                                            const Ray& ray,
                                            float cell) {
  const std::uint64_t word = grid.words[index / 64];
  std::array<int, 3> low = at;
  int size = 1;
  if (word == 0) {
    const int leap = std::max(1, static_cast<int>(grid.leaps[index / 64]));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = 4 * (at[axis] / 4 - (leap - 1));
    }
    size = 4 * (2 * leap - 1);
  } else {
    constexpr std::uint64_t kOctant = 0x330033;  // 2x2x2 cells of a block
    constexpr std::size_t kLowestOfOctant = 2 + 8 + 32;
    if ((word >> (index & kLowestOfOctant) & kOctant) == 0) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] &= ~1;
      }
      size = 2;
    }
  }
  return ExitOf(ray, low, size, cell);
}

/// Goes on from the length *t to the next sample in an occupied cell, and *t behind its step;
/// returns false where the ray leaves the box before.
DEJA_VIEW_HOST_DEVICE inline bool NextSample(const OccupancyView& grid,
                                             const Ray& ray,
                                             const TraceOptions& options,
                                             float* t,
                                             MarchSample* sample) {
  const float cell = 1 / grid.scale;
  while (*t < ray.end) {
    std::array<int, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float p = ray.origin[axis] + (*t + kNudge) * ray.direction[axis];
      at[axis] = std::clamp(static_cast<int>(p * grid.scale), 0, grid.cells[axis] - 1);
    }
    const std::size_t index = grid.Index(at[0], at[1], at[2]);
    if (!grid.IsOccupied(index)) {
      *t = std::max(*t + kNudge, LeapOver(grid, index, at, ray, cell));
      continue;
    }
    const float step =
        options.step_factor * std::clamp((ray.before + *t) * options.march.cone_angle,
                                         options.march.min_step,
                                         options.march.max_step);
    sample->dt = std::min(step, ray.end - *t);
    sample->middle = *t + ray.jitter * sample->dt;
    *t += step;
    return true;
  }
  return false;
}

/// Where a ray is at a length from its origin, within the box of side lengths `extent`.
DEJA_VIEW_HOST_DEVICE inline std::array<float, 3> PlaceOf(const Ray& ray,
                                                          float length,
                                                          const float* extent) {
  std::array<float, 3> p{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p[axis] = std::clamp(ray.origin[axis] + length * ray.direction[axis], 0.0F, extent[axis]);
  }
  return p;
}

}  // namespace deja_view::nerf::internal
