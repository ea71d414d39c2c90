#pragma once

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

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

/// The same lens on an image scaled by `scale`.
template <typename Parameters, typename Member>
Parameters ScaledLens(
    Parameters p, double scale, Member focal_x, Member focal_y, Member centre_x, Member centre_y) {
  p.width = ScaledSize(p.width, scale);
  p.height = ScaledSize(p.height, scale);
  p.*focal_x *= scale;
  p.*focal_y *= scale;
  p.*centre_x = ScaledCentre(p.*centre_x, scale);
  p.*centre_y = ScaledCentre(p.*centre_y, scale);
  return p;
}

/// Throws CheckError unless the size and `positive` are above 0 and all of `numbers` are finite.
template <typename Parameters>
void CheckLens(const Parameters& p,
               std::initializer_list<double> positive,
               std::initializer_list<double> numbers) {
  DEJA_VIEW_CHECK_OP(p.width, >, 0);
  DEJA_VIEW_CHECK_OP(p.height, >, 0);
  for (const double value : positive) {
    DEJA_VIEW_CHECK_OP(value, >, 0.0);
  }
  for (const double value : numbers) {
    DEJA_VIEW_CHECK(std::isfinite(value));
  }
}

}  // namespace deja_view::internal
