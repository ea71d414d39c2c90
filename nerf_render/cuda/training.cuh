#pragma once

#include "field_views.cuh"
#include "loss_of_ray.hpp"
#include "ray_march.hpp"

// What training does to rays and their samples, beside grids.cuh and layers.cuh.

namespace deja_view::nerf::internal {

/// Index: ray.
struct LossOfRays {
  RayLoss loss;
  float* squared_error = nullptr;  ///< per ray

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t ray) const {
    squared_error[ray] = static_cast<float>(loss(ray).squared_error);
  }
};

/// Index: sample. The density network's only output is the first of its row.
struct FirstOfRow {
  const float* values = nullptr;
  std::size_t stride = 16;
  float* rows = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t s) const {
    for (std::size_t i = 0; i < stride; ++i) {
      rows[s * stride + i] = i == 0 ? values[s] : 0.0F;
    }
  }
};

/// Index: ray x latent numbers.
struct SumLatents {
  const std::size_t* ray_begin = nullptr;
  const float* d_rows = nullptr;
  std::size_t stride = 0;
  std::size_t column = 0;
  std::size_t latent_size = 1;
  float* out = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const std::size_t ray = index / latent_size;
    float sum = 0;
    for (std::size_t s = ray_begin[ray]; s < ray_begin[ray + 1]; ++s) {
      sum += d_rows[s * stride + column + index % latent_size];
    }
    out[index] = sum;
  }
};

}  // namespace deja_view::nerf::internal
