#include "deja_view/nerf/kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace deja_view::nerf {
namespace {

struct Corners {
  std::array<std::uint32_t, 8> entry;
  std::array<float, 8> weight;
};

Corners FindCorners(const GridLevel& level, float x, float y, float z) {
  const std::array<float, 3> p = {x * level.scale, y * level.scale, z * level.scale};
  std::array<std::uint32_t, 3> cell;
  std::array<float, 3> fraction;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<std::uint32_t>(p[axis]);
    fraction[axis] = p[axis] - static_cast<float>(cell[axis]);
  }
  Corners corners;
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

void GridForward(const GridLevel& level,
                 const float* table,
                 const Positions& p,
                 std::size_t count,
                 float* out,
                 std::size_t stride) {
  const auto features = static_cast<std::size_t>(level.features);
  for (std::size_t s = 0; s < count; ++s) {
    const Corners corners = FindCorners(level, p.x[s], p.y[s], p.z[s]);
    float* row = out + s * stride;
    std::fill_n(row, features, 0.0F);
    for (std::size_t c = 0; c < 8; ++c) {
      for (std::size_t f = 0; f < features; ++f) {
        row[f] += corners.weight[c] * table[corners.entry[c] * features + f];
      }
    }
  }
}

void GridBackward(const GridLevel& level,
                  const Positions& p,
                  std::size_t count,
                  const float* d_out,
                  float* gradient,
                  std::uint8_t* touched) {
  const auto features = static_cast<std::size_t>(level.features);
  for (std::size_t s = 0; s < count; ++s) {
    const Corners corners = FindCorners(level, p.x[s], p.y[s], p.z[s]);
    for (std::size_t c = 0; c < 8; ++c) {
      touched[corners.entry[c] / 8] = 1;
      for (std::size_t f = 0; f < features; ++f) {
        gradient[corners.entry[c] * features + f] += corners.weight[c] * d_out[s * features + f];
      }
    }
  }
}

void LayerForward(const LayerShape& shape,
                  const float* weights,
                  const float* bias,
                  const float* x,
                  std::size_t count,
                  bool relu,
                  float* y) {
  const auto inputs = static_cast<std::size_t>(shape.inputs);
  const auto outputs = static_cast<std::size_t>(shape.outputs);
  for (std::size_t s = 0; s < count; ++s) {
    float* row = y + s * outputs;
    for (std::size_t o = 0; o < outputs; ++o) {
      row[o] = bias != nullptr ? bias[o] : 0.0F;
    }
    for (std::size_t i = 0; i < inputs; ++i) {
      for (std::size_t o = 0; o < outputs; ++o) {
        row[o] += x[s * inputs + i] * weights[i * outputs + o];
      }
    }
    if (relu) {
      for (std::size_t o = 0; o < outputs; ++o) {
        row[o] = std::max(0.0F, row[o]);
      }
    }
  }
}

void LayerGradient(const LayerShape& shape,
                   const float* x,
                   const float* d_y,
                   std::size_t count,
                   float* d_weights,
                   float* d_bias) {
  const auto inputs = static_cast<std::size_t>(shape.inputs);
  const auto outputs = static_cast<std::size_t>(shape.outputs);
  for (std::size_t s = 0; s < count; ++s) {
    for (std::size_t o = 0; o < outputs; ++o) {
      d_bias[o] += d_y[s * outputs + o];
    }
    for (std::size_t i = 0; i < inputs; ++i) {
      for (std::size_t o = 0; o < outputs; ++o) {
        d_weights[i * outputs + o] += x[s * inputs + i] * d_y[s * outputs + o];
      }
    }
  }
}

void Adam(const AdamStep& step,
          std::size_t count,
          float* parameters,
          float* gradient,
          float* first,
          float* second) {
  for (std::size_t i = 0; i < count; ++i) {
    const float g = gradient[i];
    first[i] += (1 - step.beta1) * (g - first[i]);
    second[i] += (1 - step.beta2) * (g * g - second[i]);
    parameters[i] -= step.learning_rate * first[i] / (std::sqrt(second[i]) + step.epsilon);
    gradient[i] = 0;
  }
}

void Density(
    const float* raw, const float* dt, std::size_t count, float* sigma, float* transparency) {
  for (std::size_t i = 0; i < count; ++i) {
    sigma[i] = std::exp(std::clamp(raw[i], -15.0F, 15.0F));
    transparency[i] = std::exp(-std::min(80.0F, sigma[i] * dt[i]));
  }
}

void Sigmoid(const float* x, std::size_t count, float* y) {
  for (std::size_t i = 0; i < count; ++i) {
    y[i] = 1 / (1 + std::exp(-std::clamp(x[i], -30.0F, 30.0F)));
  }
}

}  // namespace

const Kernels& PortableKernels() {
  static constexpr Kernels kKernels = {
      "portable", GridForward, GridBackward, LayerForward, LayerGradient, Adam, Density, Sigmoid};
  return kKernels;
}

}  // namespace deja_view::nerf
