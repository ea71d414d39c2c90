#pragma once

#include "deja_view/base/host_device.hpp"
#include "deja_view/nerf/kernel_table.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::nerf::internal {

/// One number's share of what Kernels do to arrays: the same on the CPU and on a card.

/// [1/unit length], of the density network's output, which is cut to [-15, 15].
DEJA_VIEW_HOST_DEVICE inline float DensityOf(float raw) {
  return std::exp(std::clamp(raw, -15.0F, 15.0F));
}

/// What light a step of length `dt` lets pass.
DEJA_VIEW_HOST_DEVICE inline float TransparencyOf(float sigma, float dt) {
  return std::exp(-std::min(80.0F, sigma * dt));
}

DEJA_VIEW_HOST_DEVICE inline float SigmoidOf(float x) {
  return 1 / (1 + std::exp(-std::clamp(x, -30.0F, 30.0F)));
}

/// Adam without bias correction; leaves the gradient at 0.
DEJA_VIEW_HOST_DEVICE inline void StepAdam(
    const AdamStep& step, float* parameter, float* gradient, float* first, float* second) {
  const float g = *gradient;
  *first += (1 - step.beta1) * (g - *first);
  *second += (1 - step.beta2) * (g * g - *second);
  *parameter -=
      step.learning_rate * (*first / (std::sqrt(*second) + step.epsilon) + step.decay * *parameter);
  *gradient = 0;
}

}  // namespace deja_view::nerf::internal
