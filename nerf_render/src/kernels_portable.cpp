#include "deja_view/nerf/kernels.hpp"

#include <algorithm>

#include "grid_corners.hpp"
#include "scalar_steps.hpp"

namespace deja_view::nerf {
namespace {

using internal::Corners;
using internal::FindCorners;

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
    internal::StepAdam(step, parameters + i, gradient + i, first + i, second + i);
  }
}

void Density(
    const float* raw, const float* dt, std::size_t count, float* sigma, float* transparency) {
  for (std::size_t i = 0; i < count; ++i) {
    sigma[i] = internal::DensityOf(raw[i]);
    transparency[i] = internal::TransparencyOf(sigma[i], dt[i]);
  }
}

void Sigmoid(const float* x, std::size_t count, float* y) {
  for (std::size_t i = 0; i < count; ++i) {
    y[i] = internal::SigmoidOf(x[i]);
  }
}

}  // namespace

const Kernels& PortableKernels() {
  static constexpr Kernels kKernels = {
      "portable", GridForward, GridBackward, LayerForward, LayerGradient, Adam, Density, Sigmoid};
  return kKernels;
}

}  // namespace deja_view::nerf
