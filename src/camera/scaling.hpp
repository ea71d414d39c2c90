#pragma once

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::internal {

/// Width or height after scaling, at least one pixel.
inline int ScaledSize(int size, double scale) {
  DEJA_VIEW_CHECK(std::isfinite(scale) && scale > 0);
  return std::max(1, static_cast<int>(std::lround(size * scale)));
}

/// Coordinate of a principal point after scaling: pixel 0 covers [-0.5, 0.5].
inline double ScaledCentre(double centre, double scale) {
  return (centre + 0.5) * scale - 0.5;
}

}  // namespace deja_view::internal
