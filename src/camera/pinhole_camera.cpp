#include "deja_view/camera/pinhole_camera.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

#include "radtan.hpp"
#include "scaling.hpp"

namespace deja_view {
PinholeCamera::PinholeCamera(const PinholeParameters& parameters)
    : Camera(parameters.width, parameters.height),
      parameters_(parameters),
      max_radius_squared_(internal::RadTanOf(parameters).MaxRadiusSquared()) {
  const PinholeParameters& p = parameters_;
  internal::CheckLens(p, {p.fx, p.fy}, {p.fx, p.fy, p.cx, p.cy, p.k1, p.k2, p.p1, p.p2});
}

std::optional<Eigen::Vector2d> PinholeCamera::Project(const Eigen::Vector3d& p_C,
                                                      ProjectionJacobian* J) const {
  if (!(p_C.z() > 0)) {
    return std::nullopt;
  }
  const double inverse_z = 1.0 / p_C.z();
  const Eigen::Vector2d u = p_C.head<2>() * inverse_z;
  if (!(u.squaredNorm() < max_radius_squared_)) {
    return std::nullopt;
  }
  Eigen::Matrix2d J_distortion;
  const Eigen::Vector2d d =
      internal::RadTanOf(parameters_).Distort(u, J != nullptr ? &J_distortion : nullptr);
  if (J != nullptr) {
    ProjectionJacobian J_plane;
    J_plane << inverse_z, 0, -u.x() * inverse_z, 0, inverse_z, -u.y() * inverse_z;
    *J = Eigen::Vector2d(parameters_.fx, parameters_.fy).asDiagonal() * (J_distortion * J_plane);
  }
  return Eigen::Vector2d(parameters_.fx * d.x() + parameters_.cx,
                         parameters_.fy * d.y() + parameters_.cy);
}

Eigen::Vector3d PinholeCamera::Unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d((pixel.x() - parameters_.cx) / parameters_.fx,
                          (pixel.y() - parameters_.cy) / parameters_.fy);
  const Eigen::Vector2d u = internal::RadTanOf(parameters_).Undistort(d);
  return Eigen::Vector3d(u.x(), u.y(), 1.0).normalized();
}

double PinholeCamera::FocalLength() const {
  return 0.5 * (parameters_.fx + parameters_.fy);
}

std::unique_ptr<Camera> PinholeCamera::Scaled(double scale) const {
  using P = PinholeParameters;
  return std::make_unique<PinholeCamera>(
      internal::ScaledLens(parameters_, scale, &P::fx, &P::fy, &P::cx, &P::cy));
}

}  // namespace deja_view
