#pragma once

#include "deja_view/base/host_device.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "loss_of_ray.hpp"

namespace deja_view::nerf::internal {

/// What a pixel shows.
struct PixelValues {
  std::array<std::uint8_t, 3> color{};
  float depth = 0;  ///< [m]
  float depth_variance = 0;
  float opacity = 0;
};

/// Sums over the samples of one ray.
struct PixelSum {
  TraceView trace;
  float size = 1;  ///< of the box [m]
  float gain = 1;
  float bias = 0;

  DEJA_VIEW_HOST_DEVICE PixelValues operator()(std::size_t ray, float vignetting) const {
    const std::size_t channels = trace.channels;
    std::array<float, 3> color{};
    float sum = 0;
    float sum_t = 0;
    float sum_t2 = 0;
    for (std::size_t s = trace.ray_begin[ray]; s < trace.ray_begin[ray + 1]; ++s) {
      const float w = trace.weight[s];
      sum += w;
      sum_t += w * trace.t[s];
      for (std::size_t c = 0; c < channels; ++c) {
        color[c] += w * trace.color[s * channels + c];
      }
    }
    for (std::size_t c = 0; c < channels && trace.background != nullptr; ++c) {
      color[c] += trace.transmittance[ray] * trace.background[ray * channels + c];
    }
    const float mean = sum > 0 ? sum_t / sum : 0.0F;
    for (std::size_t s = trace.ray_begin[ray]; s < trace.ray_begin[ray + 1]; ++s) {
      sum_t2 += trace.weight[s] * (trace.t[s] - mean) * (trace.t[s] - mean);
    }
    PixelValues pixel;
    for (std::size_t c = 0; c < channels; ++c) {
      const float value = gain * vignetting * color[c] + bias;
      pixel.color[c] = static_cast<std::uint8_t>(std::clamp(255 * value + 0.5F, 0.0F, 255.0F));
    }
    pixel.depth = mean * size;
    pixel.depth_variance = sum > 0 ? sum_t2 / sum * size * size : 0.0F;
    pixel.opacity = std::min(1.0F, sum);
    return pixel;
  }
};

}  // namespace deja_view::nerf::internal
