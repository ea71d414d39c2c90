#pragma once

#include "deja_view/base/host_device.hpp"

#include <cmath>

namespace deja_view::internal {

/// Solves f(x) = target for f increasing on [low, high] with f(low) <= target: Newton's iteration,
/// with a bisection step whenever it would leave the bracket. `f(x, &derivative)` returns the
/// value. Returns `high` when the target lies beyond f(high).
template <typename Function>
DEJA_VIEW_HOST_DEVICE double InvertIncreasing(const Function& f,
                                              double target,
                                              double low,
                                              double high) {
  double derivative = 1.0;
  if (f(high, &derivative) <= target) {
    return high;
  }
  double x = std::fmin(std::fmax(target, low), high);
  for (int i = 0; i < 100; ++i) {
    const double error = f(x, &derivative) - target;
    if (error == 0) {
      break;
    }
    (error > 0 ? high : low) = x;
    double next = x - error / derivative;
    if (!(next >= low && next <= high)) {
      next = 0.5 * (low + high);
    }
    const double step = std::abs(next - x);
    x = next;
    if (step <= 1e-15 * std::abs(x)) {
      break;
    }
  }
  return x;
}

}  // namespace deja_view::internal
