#pragma once

#include <algorithm>

#include "field_views.cuh"

// What networks do to rows of samples, as functions of an index: one thread each.

namespace deja_view::nerf::internal {

/// Index: sample x outputs. Kernels::layer_forward.
struct LayerForward {
  LayerView layer;
  const float* x = nullptr;
  bool relu = false;
  float* y = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const std::size_t s = index / layer.outputs;
    const std::size_t o = index % layer.outputs;
    float sum = layer.bias[o];
    for (std::size_t i = 0; i < layer.inputs; ++i) {
      sum += x[s * layer.inputs + i] * layer.weights[i * layer.outputs + o];
    }
    y[index] = relu && !(sum > 0) ? 0.0F : sum;
  }
};

/// Index: sample x inputs. The derivative by a layer's input, behind the ReLU that made it where
/// `in` is given.
struct LayerBackward {
  LayerView layer;
  const float* d_y = nullptr;
  const float* in = nullptr;
  float* d_x = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const std::size_t s = index / layer.inputs;
    const std::size_t i = index % layer.inputs;
    float sum = 0;
    for (std::size_t o = 0; o < layer.outputs; ++o) {
      sum += d_y[s * layer.outputs + o] * layer.weights[i * layer.outputs + o];
    }
    d_x[index] = in != nullptr && !(in[index] > 0) ? 0.0F : sum;
  }
};

constexpr std::size_t kSamplesPerSum = 512;

/// Index: group of samples x (weights, then biases). Sums over a group, to be added up by
/// AddGroups: in a fixed order, hence the same bits every time.
struct LayerGradient {
  LayerView layer;
  const float* x = nullptr;
  const float* d_y = nullptr;
  std::size_t samples = 0;
  float* sums = nullptr;

  DEJA_VIEW_HOST_DEVICE std::size_t width() const { return (layer.inputs + 1) * layer.outputs; }
  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const std::size_t i = index % width() / layer.outputs;
    const std::size_t o = index % layer.outputs;
    const std::size_t begin = index / width() * kSamplesPerSum;
    const std::size_t end = std::min(samples, begin + kSamplesPerSum);
    float sum = 0;
    for (std::size_t s = begin; s < end; ++s) {
      const float in = i < layer.inputs ? x[s * layer.inputs + i] : 1.0F;
      sum += in * d_y[s * layer.outputs + o];
    }
    sums[index] = sum;
  }
};

/// Index: number. Adds the sums of all groups.
struct AddGroups {
  const float* sums = nullptr;
  std::size_t groups = 0;
  std::size_t width = 0;
  float* out = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    float sum = 0;
    for (std::size_t g = 0; g < groups; ++g) {
      sum += sums[g * width + index];
    }
    out[index] += sum;
  }
};

/// Index: sample x channels.
struct SigmoidOfRows {
  const float* rows = nullptr;
  std::size_t stride = 0;
  std::size_t channels = 1;
  float* out = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    out[index] = SigmoidOf(rows[index / channels * stride + index % channels]);
  }
};

/// What Adam works on.
struct AdamArrays {
  float* parameters = nullptr;
  float* gradient = nullptr;
  float* first = nullptr;
  float* second = nullptr;
};

/// Index: number.
struct AdamOfAll {
  AdamStep step;
  AdamArrays arrays;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t i) const {
    StepAdam(step, arrays.parameters + i, arrays.gradient + i, arrays.first + i, arrays.second + i);
  }
};

/// Index: number. Only bricks that samples touched, as GridOptimizer; their marks are wiped by
/// whoever launches this.
struct AdamOfTouched {
  AdamStep step;
  AdamArrays arrays;
  const std::uint8_t* touched = nullptr;
  std::size_t brick = 16;  ///< numbers

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t i) const {
    if (touched[i / brick] != 0) {
      AdamOfAll{step, arrays}(i);
    }
  }
};

}  // namespace deja_view::nerf::internal
