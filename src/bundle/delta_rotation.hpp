#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <cmath>

#include <Eigen/Core>

namespace deja_view::internal {

/// Exp(w) of a rotation vector w [rad] and its left Jacobian J: Exp(w + dw) = Exp(J dw) Exp(w) to
/// first order. Rotations are adjusted as R = Exp(w) R_reference with w near 0, so that the solver
/// needs no manifold.
struct DeltaRotation {
  explicit DeltaRotation(const double* w) {
    const Eigen::Vector3d v(w[0], w[1], w[2]);
    const double s = v.squaredNorm();
    double a = 1.0 - s / 6.0;
    double b = 0.5 - s / 24.0;
    double c = 1.0 / 6.0 - s / 120.0;
    constexpr double kSmall = 1e-6;  // the series' next term is below 1e-14
    if (s > kSmall) {
      const double angle = std::sqrt(s);
      a = std::sin(angle) / angle;
      b = (1.0 - std::cos(angle)) / s;
      c = (1.0 - a) / s;
    }
    const Eigen::Matrix3d K = Skew(v);
    const Eigen::Matrix3d K2 = K * K;
    R = Eigen::Matrix3d::Identity() + a * K + b * K2;
    J = Eigen::Matrix3d::Identity() + b * K + c * K2;
  }

  Eigen::Matrix3d R;
  Eigen::Matrix3d J;
};

}  // namespace deja_view::internal
