#pragma once

#include <vector>

#include <Eigen/Core>

namespace deja_view::sim {

/// Uniform quintic B-spline in R^4 (x, y, z, yaw): four times continuously differentiable, so that
/// body rates derived from its accelerations are smooth too. Control point i acts on [i - 5, i + 1)
/// steps.
class QuinticSpline {
 public:
  using Value = Eigen::Vector4d;

  /// `points`: at least 6; throws CheckError otherwise. `step` [s] between knots.
  QuinticSpline(std::vector<Value> points, double step);

  double duration() const { return step_ * static_cast<double>(points_.size() - 5); }

  /// Value or derivative of the given order (0 to 3) at t, clamped to [0, duration].
  Value Evaluate(double t, int order) const;

 private:
  std::vector<Value> points_;
  double step_;
};

}  // namespace deja_view::sim
