#pragma once

#include <optional>

#include <Eigen/Core>

namespace deja_view::internal {

/// Radial (k1, k2) and tangential (p1, p2) distortion of the normalised image plane, as OpenCV's
/// first four coefficients (Brown 1966).
struct RadTan {
  double k1 = 0;
  double k2 = 0;
  double p1 = 0;
  double p2 = 0;

  /// Distorted position of `u`; `J`, when given, receives its derivative.
  Eigen::Vector2d Distort(const Eigen::Vector2d& u, Eigen::Matrix2d* J) const;

  /// Inverse of Distort, to rounding. For a position that no undistorted point reaches, the point
  /// at the largest valid radius in its direction.
  Eigen::Vector2d Undistort(const Eigen::Vector2d& d) const;

  /// Squared radius up to which the radial polynomial increases (infinite when it always does).
  /// Beyond it the image folds back, so that nothing is seen there.
  double MaxRadiusSquared() const;

 private:
  std::optional<Eigen::Vector2d> UndistortNear(const Eigen::Vector2d& d,
                                               double max_radius_squared) const;
};

/// That of PinholeParameters and MeiParameters.
template <typename Lens>
RadTan RadTanOf(const Lens& lens) {
  return {lens.k1, lens.k2, lens.p1, lens.p2};
}

}  // namespace deja_view::internal
