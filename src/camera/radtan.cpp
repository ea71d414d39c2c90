#include "radtan.hpp"

#include "deja_view/camera/newton.hpp"

#include <cmath>
#include <limits>

#include <Eigen/LU>

namespace deja_view::internal {
namespace {

// Stands for infinity in brackets: 89.9999 degrees off the axis.
constexpr double kLargestRadius = 1e6;

}  // namespace

Eigen::Vector2d RadTan::Distort(const Eigen::Vector2d& u, Eigen::Matrix2d* J) const {
  const double x = u.x();
  const double y = u.y();
  const double s = u.squaredNorm();
  const double g = 1.0 + s * (k1 + s * k2);
  if (J != nullptr) {
    const double dg = k1 + 2.0 * s * k2;
    const double cross = 2.0 * (x * y * dg + p1 * x + p2 * y);
    *J << g + 2.0 * x * x * dg + 2.0 * p1 * y + 6.0 * p2 * x, cross,  //
        cross, g + 2.0 * y * y * dg + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * g + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
          y * g + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y};
}

double RadTan::MaxRadiusSquared() const {
  // Smallest positive root of d/dr r (1 + k1 r^2 + k2 r^4) = 1 + 3 k1 s + 5 k2 s^2, s = r^2.
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double discriminant = 9.0 * k1 * k1 - 20.0 * k2;
  if (discriminant < 0) {
    return kInfinity;
  }
  // 2c / (-b ± sqrt) keeps its digits when k2 is tiny; the larger denominator is the smaller root.
  const double denominator = -3.0 * k1 + std::sqrt(discriminant);
  return denominator > 0 ? 2.0 / denominator : kInfinity;
}

// Newton's iteration from `d` itself: all that common lenses need.
std::optional<Eigen::Vector2d> RadTan::UndistortNear(const Eigen::Vector2d& d,
                                                     double max_radius_squared) const {
  constexpr int kMaxSteps = 8;
  constexpr double kRounding = 1e-15;
  Eigen::Vector2d u = d;
  for (int i = 0; i < kMaxSteps; ++i) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d residual = Distort(u, &J) - d;
    const Eigen::Vector2d step = J.inverse() * residual;
    u -= step;
    // Within the valid circle the inverse is unique.
    if (!(u.squaredNorm() < max_radius_squared) || !(J.determinant() > 0)) {
      return std::nullopt;
    }
    if (step.squaredNorm() <= kRounding * u.squaredNorm()) {
      return u;
    }
  }
  return std::nullopt;
}

Eigen::Vector2d RadTan::Undistort(const Eigen::Vector2d& d) const {
  if (const auto near = UndistortNear(d, 0.9 * MaxRadiusSquared())) {
    return *near;
  }
  const double radius_d = d.norm();
  if (radius_d == 0) {
    return d;
  }
  const double max_radius = std::fmin(std::sqrt(MaxRadiusSquared()), kLargestRadius);
  const auto radial = [this](double r, double* derivative) {
    const double s = r * r;
    *derivative = 1.0 + s * (3.0 * k1 + 5.0 * s * k2);
    return r * (1.0 + s * (k1 + s * k2));
  };
  const double radius = InvertIncreasing(radial, radius_d, 0.0, max_radius);
  Eigen::Vector2d u = d * (radius / radius_d);
  if (radius >= max_radius) {
    return u;
  }
  // The tangential part is small: Newton's iteration from the radial solution, kept only while it
  // helps.
  Eigen::Matrix2d J;
  Eigen::Vector2d residual = Distort(u, &J) - d;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d next = u - J.inverse() * residual;
    Eigen::Matrix2d J_next;
    const Eigen::Vector2d residual_next = Distort(next, &J_next) - d;
    if (!(residual_next.squaredNorm() < residual.squaredNorm()) || next.norm() > max_radius) {
      break;
    }
    u = next;
    J = J_next;
    residual = residual_next;
  }
  return u;
}

}  // namespace deja_view::internal
