#include "deja_view/camera/kannala_brandt_camera.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/camera/newton.hpp"

#include <cmath>

#include "scaling.hpp"

namespace deja_view {
KannalaBrandtCamera::KannalaBrandtCamera(const KannalaBrandtParameters& parameters)
    : Camera(parameters.width, parameters.height), parameters_(parameters), max_theta_(kPi) {
  const KannalaBrandtParameters& p = parameters_;
  internal::CheckLens(p, {p.mu, p.mv}, {p.mu, p.mv, p.u0, p.v0, p.k2, p.k3, p.k4, p.k5});
  max_theta_ = LargestAngle();
}

double KannalaBrandtCamera::Radius(double theta, double* derivative) const {
  const KannalaBrandtParameters& p = parameters_;
  const double s = theta * theta;
  *derivative = 1.0 + s * (3.0 * p.k2 + s * (5.0 * p.k3 + s * (7.0 * p.k4 + s * 9.0 * p.k5)));
  return theta * (1.0 + s * (p.k2 + s * (p.k3 + s * (p.k4 + s * p.k5))));
}

double KannalaBrandtCamera::LargestAngle() const {
  constexpr int kSteps = 1800;
  double derivative = 1.0;
  for (int i = 1; i <= kSteps; ++i) {
    const double theta = kPi * i / kSteps;
    Radius(theta, &derivative);
    if (derivative > 0) {
      continue;
    }
    double low = kPi * (i - 1) / kSteps;
    double high = theta;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      Radius(middle, &derivative);
      (derivative > 0 ? low : high) = middle;
    }
    return low;
  }
  return kPi;
}

std::optional<Eigen::Vector2d> KannalaBrandtCamera::Project(const Eigen::Vector3d& p_C,
                                                            ProjectionJacobian* J) const {
  const double planar = std::hypot(p_C.x(), p_C.y());
  const double theta = std::atan2(planar, p_C.z());
  // atan2(0, 0) = 0: the centre of projection itself has no direction.
  if (!(theta < max_theta_) || !(p_C.squaredNorm() > 0)) {
    return std::nullopt;
  }
  double derivative = 1.0;
  const double radius = Radius(theta, &derivative);
  // On the axis radius / planar tends to 1 / z.
  const bool is_on_axis = planar < 1e-12 * std::abs(p_C.z());
  const double ratio = is_on_axis ? 1.0 / p_C.z() : radius / planar;
  const Eigen::Vector2d d = ratio * p_C.head<2>();
  if (J != nullptr) {
    Eigen::Matrix<double, 2, 3> J_d = Eigen::Matrix<double, 2, 3>::Zero();
    J_d.leftCols<2>().diagonal().setConstant(ratio);
    if (!is_on_axis) {
      // d = radius(theta) * e, e = (x, y) / planar; theta depends on planar and z.
      const Eigen::Vector2d e = p_C.head<2>() / planar;
      const double d_theta = derivative / p_C.squaredNorm();
      J_d.leftCols<2>() += (d_theta * p_C.z() - ratio) * e * e.transpose();
      J_d.col(2) = -d_theta * planar * e;
    }
    *J = Eigen::Vector2d(parameters_.mu, parameters_.mv).asDiagonal() * J_d;
  }
  return Eigen::Vector2d(parameters_.mu * d.x() + parameters_.u0,
                         parameters_.mv * d.y() + parameters_.v0);
}

Eigen::Vector3d KannalaBrandtCamera::Unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d((pixel.x() - parameters_.u0) / parameters_.mu,
                          (pixel.y() - parameters_.v0) / parameters_.mv);
  const double radius = d.norm();
  if (radius == 0) {
    return Eigen::Vector3d::UnitZ();
  }
  const auto function = [this](double theta, double* derivative) {
    return Radius(theta, derivative);
  };
  const double theta = internal::InvertIncreasing(function, radius, 0.0, max_theta_);
  const Eigen::Vector2d planar = d * (std::sin(theta) / radius);
  return {planar.x(), planar.y(), std::cos(theta)};
}

double KannalaBrandtCamera::FocalLength() const {
  return 0.5 * (parameters_.mu + parameters_.mv);
}

std::unique_ptr<Camera> KannalaBrandtCamera::Scaled(double scale) const {
  using P = KannalaBrandtParameters;
  return std::make_unique<KannalaBrandtCamera>(
      internal::ScaledLens(parameters_, scale, &P::mu, &P::mv, &P::u0, &P::v0));
}

}  // namespace deja_view
