#include "deja_view/lab/sim/spline.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace deja_view::sim {

QuinticSpline::QuinticSpline(std::vector<Value> points, double step)
    : points_(std::move(points)), step_(step) {
  DEJA_VIEW_CHECK_OP(points_.size(), >=, 6U);
  DEJA_VIEW_CHECK_OP(step, >, 0.0);
}

/// De Boor's algorithm on uniform knots; a derivative is the spline of lower degree through
/// differences.
QuinticSpline::Value QuinticSpline::Evaluate(double t, int order) const {
  const double position = std::clamp(t, 0.0, duration()) / step_;
  const auto segment = std::min(static_cast<std::size_t>(position), points_.size() - 6);
  const double u = position - static_cast<double>(segment);
  std::array<Value, 6> p;
  std::copy_n(points_.begin() + static_cast<std::ptrdiff_t>(segment), 6, p.begin());
  int degree = 5;
  for (; order > 0; --order, --degree) {
    for (int i = 0; i < degree; ++i) {
      p[i] = (p[i + 1] - p[i]) / step_;
    }
  }
  for (int level = degree; level > 0; --level) {
    for (int i = 0; i < level; ++i) {
      // Knots that bound the support of point i at this level are `level` steps apart.
      const double weight = (u + level - 1 - i) / level;
      p[i] = (1.0 - weight) * p[i] + weight * p[i + 1];
    }
  }
  return p[0];
}

}  // namespace deja_view::sim
