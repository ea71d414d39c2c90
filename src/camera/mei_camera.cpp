#include "deja_view/camera/mei_camera.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

#include "radtan.hpp"
#include "scaling.hpp"

namespace deja_view {
MeiCamera::MeiCamera(const MeiParameters& parameters)
    : Camera(parameters.width, parameters.height),
      parameters_(parameters),
      max_radius_squared_(internal::RadTanOf(parameters).MaxRadiusSquared()) {
  const MeiParameters& p = parameters_;
  internal::CheckLens(
      p, {p.gamma1, p.gamma2}, {p.xi, p.k1, p.k2, p.p1, p.p2, p.gamma1, p.gamma2, p.u0, p.v0});
  DEJA_VIEW_CHECK_OP(p.xi, >=, 0.0);
}

std::optional<Eigen::Vector2d> MeiCamera::Project(const Eigen::Vector3d& p_C,
                                                  ProjectionJacobian* J) const {
  const MeiParameters& p = parameters_;
  const double norm = p_C.norm();
  const double min_cosine = p.xi <= 1.0 ? -p.xi : -1.0 / p.xi;
  if (!(norm > 0) || !(p_C.z() > min_cosine * norm)) {
    return std::nullopt;
  }
  const double denominator = p_C.z() + p.xi * norm;
  const Eigen::Vector2d u = p_C.head<2>() / denominator;
  if (!(u.squaredNorm() < max_radius_squared_)) {
    return std::nullopt;
  }
  Eigen::Matrix2d J_distortion;
  const Eigen::Vector2d d =
      internal::RadTanOf(p).Distort(u, J != nullptr ? &J_distortion : nullptr);
  if (J != nullptr) {
    Eigen::RowVector3d d_denominator = (p.xi / norm) * p_C.transpose();
    d_denominator.z() += 1.0;
    ProjectionJacobian J_plane = -u * d_denominator;
    J_plane.leftCols<2>().diagonal().array() += 1.0;
    J_plane /= denominator;
    *J = Eigen::Vector2d(p.gamma1, p.gamma2).asDiagonal() * (J_distortion * J_plane);
  }
  return Eigen::Vector2d(p.gamma1 * d.x() + p.u0, p.gamma2 * d.y() + p.v0);
}

Eigen::Vector3d MeiCamera::Unproject(const Eigen::Vector2d& pixel) const {
  const MeiParameters& p = parameters_;
  const Eigen::Vector2d d((pixel.x() - p.u0) / p.gamma1, (pixel.y() - p.v0) / p.gamma2);
  Eigen::Vector2d u = internal::RadTanOf(p).Undistort(d);
  if (p.xi > 1.0) {
    // The sphere's outline: nothing projects beyond it.
    const double limit = 1.0 / std::sqrt(p.xi * p.xi - 1.0);
    u *= limit / std::max(u.norm(), limit);
  }
  const double s = u.squaredNorm();
  const double root = std::sqrt(std::max(0.0, 1.0 + (1.0 - p.xi * p.xi) * s));
  const double factor = (p.xi + root) / (s + 1.0);
  return Eigen::Vector3d(factor * u.x(), factor * u.y(), factor - p.xi).normalized();
}

double MeiCamera::FocalLength() const {
  return 0.5 * (parameters_.gamma1 + parameters_.gamma2) / (1.0 + parameters_.xi);
}

std::unique_ptr<Camera> MeiCamera::Scaled(double scale) const {
  using P = MeiParameters;
  return std::make_unique<MeiCamera>(
      internal::ScaledLens(parameters_, scale, &P::gamma1, &P::gamma2, &P::u0, &P::v0));
}

}  // namespace deja_view
