#pragma once

#include "deja_view/base/host_device.hpp"
#include "deja_view/camera/newton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace deja_view::nerf::internal {

/// A camera's lens in plain numbers, for CPU and card alike. The models and the names of their
/// parameters are those of PinholeCamera, KannalaBrandtCamera and MeiCamera.
struct LensView {
  enum class Model { kPinhole, kKannalaBrandt, kMei };

  Model model = Model::kPinhole;
  double fx = 1;  ///< [px]; mu, gamma1
  double fy = 1;
  double cx = 0;  ///< [px]; u0
  double cy = 0;
  double xi = 0;              ///< MEI's
  std::array<double, 4> k{};  ///< k1 k2 p1 p2, or k2 k3 k4 k5
  double limit = 1e6;         ///< radius, or angle [rad], up to which the lens is one-to-one

  /// Unit vector in C towards what the pixel sees: Camera::Unproject.
  DEJA_VIEW_HOST_DEVICE std::array<double, 3> Unproject(double u, double v) const;

 private:
  struct Plane {
    double x = 0;
    double y = 0;
  };
  struct Distorted {
    Plane value;
    double xx = 1;  ///< derivatives: symmetric
    double xy = 0;
    double yy = 1;
  };
  DEJA_VIEW_HOST_DEVICE Distorted Distort(const Plane& u) const;
  DEJA_VIEW_HOST_DEVICE bool StepNear(const Plane& d, Plane* u, bool* is_done) const;
  DEJA_VIEW_HOST_DEVICE Plane Undistort(const Plane& d) const;
  DEJA_VIEW_HOST_DEVICE Plane UndistortFar(const Plane& d) const;
};

/// The radial part of a lens' distortion, and its derivative.
struct RadialPolynomial {
  double k1 = 0;
  double k2 = 0;
  DEJA_VIEW_HOST_DEVICE double operator()(double r, double* derivative) const {
    const double s = r * r;
    *derivative = 1.0 + s * (3.0 * k1 + 5.0 * s * k2);
    return r * (1.0 + s * (k1 + s * k2));
  }
};
struct AnglePolynomial {
  std::array<double, 4> k{};
  DEJA_VIEW_HOST_DEVICE double operator()(double theta, double* derivative) const {
    const double s = theta * theta;
    *derivative = 1.0 + s * (3.0 * k[0] + s * (5.0 * k[1] + s * (7.0 * k[2] + s * 9.0 * k[3])));
    return theta * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))));
  }
};

DEJA_VIEW_HOST_DEVICE inline LensView::Distorted LensView::Distort(const Plane& u) const {
  const double s = u.x * u.x + u.y * u.y;
  const double g = 1.0 + s * (k[0] + s * k[1]);
  const double dg = k[0] + 2.0 * s * k[1];
  Distorted d;
  d.value.x = u.x * g + 2.0 * k[2] * u.x * u.y + k[3] * (s + 2.0 * u.x * u.x);
  d.value.y = u.y * g + k[2] * (s + 2.0 * u.y * u.y) + 2.0 * k[3] * u.x * u.y;
  d.xx = g + 2.0 * u.x * u.x * dg + 2.0 * k[2] * u.y + 6.0 * k[3] * u.x;
  d.xy = 2.0 * (u.x * u.y * dg + k[2] * u.x + k[3] * u.y);
  d.yy = g + 2.0 * u.y * u.y * dg + 6.0 * k[2] * u.y + 2.0 * k[3] * u.x;
  return d;
}

// One of Newton's steps from *u; false where it leaves what is surely one-to-one.
DEJA_VIEW_HOST_DEVICE inline bool LensView::StepNear(const Plane& d,
                                                     Plane* u,
                                                     bool* is_done) const {
  constexpr double kRounding = 1e-15;
  const Distorted at = Distort(*u);
  const double determinant = at.xx * at.yy - at.xy * at.xy;
  const double rx = at.value.x - d.x;
  const double ry = at.value.y - d.y;
  const double sx = (at.yy * rx - at.xy * ry) / determinant;
  const double sy = (at.xx * ry - at.xy * rx) / determinant;
  u->x -= sx;
  u->y -= sy;
  const double norm2 = u->x * u->x + u->y * u->y;
  *is_done = sx * sx + sy * sy <= kRounding * norm2;
  return norm2 < 0.9 * limit * limit && determinant > 0;
}

DEJA_VIEW_HOST_DEVICE inline LensView::Plane LensView::Undistort(const Plane& d) const {
  constexpr int kMaxSteps = 8;
  Plane u = d;
  bool is_done = false;
  for (int i = 0; i < kMaxSteps && StepNear(d, &u, &is_done); ++i) {
    if (is_done) {
      return u;
    }
  }
  return UndistortFar(d);
}

// By the radial part alone, then Newton's iteration while it helps: the tangential part is small.
DEJA_VIEW_HOST_DEVICE inline LensView::Plane LensView::UndistortFar(const Plane& d) const {
  const double radius_d = std::sqrt(d.x * d.x + d.y * d.y);
  if (radius_d == 0) {
    return d;
  }
  const RadialPolynomial radial{k[0], k[1]};
  const double radius = deja_view::internal::InvertIncreasing(radial, radius_d, 0.0, limit);
  Plane u{d.x * (radius / radius_d), d.y * (radius / radius_d)};
  if (radius >= limit) {
    return u;
  }
  Distorted at = Distort(u);
  double error2 = std::numeric_limits<double>::max();
  for (int i = 0; i < 21; ++i) {
    const double rx = at.value.x - d.x;
    const double ry = at.value.y - d.y;
    error2 = rx * rx + ry * ry;
    const double determinant = at.xx * at.yy - at.xy * at.xy;
    const Plane next{u.x - (at.yy * rx - at.xy * ry) / determinant,
                     u.y - (at.xx * ry - at.xy * rx) / determinant};
    const Distorted at_next = Distort(next);
    const double nx = at_next.value.x - d.x;
    const double ny = at_next.value.y - d.y;
    if (!(nx * nx + ny * ny < error2) || next.x * next.x + next.y * next.y > limit * limit) {
      break;
    }
    u = next;
    at = at_next;
  }
  return u;
}

DEJA_VIEW_HOST_DEVICE inline std::array<double, 3> LensView::Unproject(double u, double v) const {
  const Plane d{(u - cx) / fx, (v - cy) / fy};
  if (model == Model::kKannalaBrandt) {
    const double radius = std::sqrt(d.x * d.x + d.y * d.y);
    if (radius == 0) {
      return {0, 0, 1};
    }
    const AnglePolynomial angle{k};
    const double theta = deja_view::internal::InvertIncreasing(angle, radius, 0.0, limit);
    const double factor = std::sin(theta) / radius;
    return {d.x * factor, d.y * factor, std::cos(theta)};
  }
  Plane plane = Undistort(d);
  double z = 1;
  if (model == Model::kMei) {
    if (xi > 1.0) {
      // The sphere's outline: nothing projects beyond it.
      const double outline = 1.0 / std::sqrt(xi * xi - 1.0);
      const double norm = std::sqrt(plane.x * plane.x + plane.y * plane.y);
      const double shrink = outline / std::max(norm, outline);
      plane = {plane.x * shrink, plane.y * shrink};
    }
    const double s = plane.x * plane.x + plane.y * plane.y;
    const double factor = (xi + std::sqrt(std::max(0.0, 1.0 + (1.0 - xi * xi) * s))) / (s + 1.0);
    plane = {factor * plane.x, factor * plane.y};
    z = factor - xi;
  }
  const double norm = std::sqrt(plane.x * plane.x + plane.y * plane.y + z * z);
  return {plane.x / norm, plane.y / norm, z / norm};
}

}  // namespace deja_view::nerf::internal
