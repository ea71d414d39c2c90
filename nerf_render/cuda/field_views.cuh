#pragma once

#include "deja_view/base/host_device.hpp"
#include "deja_view/nerf/kernel_table.hpp"
#include "deja_view/nerf/occupancy_view.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

#include "grid_corners.hpp"
#include "scalar_steps.hpp"

namespace deja_view::nerf::internal {

/// A feature grid on a device.
struct GridView {
  const GridLevel* levels = nullptr;
  std::size_t level_count = 0;
  std::size_t features = 0;  ///< per level
  const float* values = nullptr;
};

/// A layer of a network on a device; weights are inputs x outputs, biases follow them.
struct LayerView {
  std::size_t inputs = 0;
  std::size_t outputs = 0;
  const float* weights = nullptr;
  const float* bias = nullptr;
};

/// What tells the density at a place.
struct DensityView {
  GridView grid;
  LayerView hidden;
  LayerView out;

  /// Features of the place, and 0 behind them; `inputs` of them are written.
  DEJA_VIEW_HOST_DEVICE void ReadFeatures(const std::array<float, 3>& p,
                                          std::size_t inputs,
                                          float* x) const;

  /// Logarithm of the density there. kInputs is at least hidden.inputs; known in advance, the
  /// features stay in registers.
  template <std::size_t kInputs>
  DEJA_VIEW_HOST_DEVICE float LogDensity(const std::array<float, 3>& p) const;
};

/// Writes the features of one level; in the order of Kernels::grid_forward.
DEJA_VIEW_HOST_DEVICE inline void ReadLevel(const GridLevel& level,
                                            const float* table,
                                            const std::array<float, 3>& p,
                                            float* out) {
  const Corners corners = FindCorners(level, p[0], p[1], p[2]);
  const auto features = static_cast<std::size_t>(level.features);
  for (std::size_t f = 0; f < features; ++f) {
    float sum = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      sum += corners.weight[c] * table[corners.entry[c] * features + f];
    }
    out[f] = sum;
  }
}

DEJA_VIEW_HOST_DEVICE inline void DensityView::ReadFeatures(const std::array<float, 3>& p,
                                                            std::size_t inputs,
                                                            float* x) const {
  for (std::size_t l = 0; l < grid.level_count; ++l) {
    const GridLevel& level = grid.levels[l];
    ReadLevel(level, grid.values + level.offset, p, x + l * grid.features);
  }
  for (std::size_t i = grid.level_count * grid.features; i < inputs; ++i) {
    x[i] = 0;
  }
}

template <std::size_t kInputs>
DEJA_VIEW_HOST_DEVICE float DensityView::LogDensity(const std::array<float, 3>& p) const {
  float x[kInputs];
  ReadFeatures(p, kInputs, x);
  float result = out.bias[0];
  for (std::size_t h = 0; h < hidden.outputs; ++h) {
    float y = hidden.bias[h];
    for (std::size_t i = 0; i < kInputs; ++i) {
      if (i < hidden.inputs) {
        y += x[i] * hidden.weights[i * hidden.outputs + h];
      }
    }
    result += (y > 0 ? y : 0.0F) * out.weights[h * out.outputs];
  }
  return result;
}

/// Positions of samples on a device.
struct PlaceArrays {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;

  DEJA_VIEW_HOST_DEVICE std::array<float, 3> operator[](std::size_t i) const {
    return {x[i], y[i], z[i]};
  }
};

/// Adds to a number that other threads may add to.
DEJA_VIEW_HOST_DEVICE inline void AtomicAdd(float* to, float value) {
#if defined(__CUDA_ARCH__)
  atomicAdd(to, value);
#else
  float old = *to;
  float next = old + value;
  while (!__atomic_compare_exchange(to, &old, &next, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    next = old + value;
  }
#endif
}

}  // namespace deja_view::nerf::internal
