#include "deja_view/lab/sim/scene.hpp"

#include "deja_view/base/angles.hpp"

#include <cmath>
#include <limits>

namespace deja_view::sim {
namespace {

constexpr double kTwoPi = 2 * kPi;

struct Candidate {
  double range, u, v;
};

std::optional<Candidate> HitPlane(const Surface& s,
                                  const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) {
  const Eigen::Vector3d axis_u = s.axis_u.cast<double>();
  const Eigen::Vector3d axis_v = s.axis_v.cast<double>();
  const Eigen::Vector3d normal = axis_u.cross(axis_v);
  const double slope = normal.dot(direction);
  const Eigen::Vector3d from_corner = origin - s.origin.cast<double>();
  const double range = -normal.dot(from_corner) / slope;
  if (!(slope < 0) || !(range > 0)) {
    return std::nullopt;
  }
  const Eigen::Vector3d p = from_corner + range * direction;
  const double u = axis_u.dot(p);
  const double v = axis_v.dot(p);
  bool inside = u >= 0 && u <= s.size_u && v >= 0 && v <= s.size_v;
  if (s.shape == Shape::kDisc) {
    inside = std::hypot(2 * u / s.size_u - 1, 2 * v / s.size_v - 1) <= 1;
  }
  return inside ? std::optional<Candidate>({range, u, v}) : std::nullopt;
}

/// Nearer root of |(w + t d) without its part along the axis|^2 = r^2, seen from outside.
std::optional<Candidate> HitMantle(const Surface& s,
                                   const Eigen::Vector3d& origin,
                                   const Eigen::Vector3d& direction) {
  const Eigen::Vector3d axis = s.axis_v.cast<double>();
  const Eigen::Vector3d w = origin - s.origin.cast<double>();
  const Eigen::Vector3d w_across = w - w.dot(axis) * axis;
  const Eigen::Vector3d d_across = direction - direction.dot(axis) * axis;
  const double r = s.Radius();
  const double a = d_across.squaredNorm();
  const double b = w_across.dot(d_across);
  const double c = w_across.squaredNorm() - r * r;
  const double discriminant = b * b - a * c;
  if (c < 0 || discriminant < 0 || a == 0) {
    return std::nullopt;
  }
  const double range = (-b - std::sqrt(discriminant)) / a;
  const Eigen::Vector3d p = w + range * direction;
  const double v = p.dot(axis);
  if (!(range > 0) || v < 0 || v > s.size_v) {
    return std::nullopt;
  }
  const Eigen::Vector3d axis_u = s.axis_u.cast<double>();
  const double angle = std::atan2(p.dot(axis.cross(axis_u)), p.dot(axis_u));
  return Candidate{range, (angle < 0 ? angle + kTwoPi : angle) * r, v};
}

}  // namespace

Eigen::Vector3f Surface::Point(float u, float v) const {
  if (shape != Shape::kCylinder) {
    return origin + u * axis_u + v * axis_v;
  }
  return origin + Radius() * NormalAt(u) + v * axis_v;
}

Eigen::Vector3f Surface::NormalAt(float u) const {
  if (shape != Shape::kCylinder) {
    return Normal();
  }
  const float angle = u / Radius();
  return std::cos(angle) * axis_u + std::sin(angle) * axis_v.cross(axis_u);
}

std::optional<Hit> CastRay(const Scene& scene,
                           const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction) {
  int nearest = -1;
  Candidate best{std::numeric_limits<double>::infinity(), 0, 0};
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const Surface& s = scene.surfaces[i];
    const auto candidate = s.shape == Shape::kCylinder ? HitMantle(s, origin, direction)
                                                       : HitPlane(s, origin, direction);
    if (candidate && candidate->range < best.range) {
      best = *candidate;
      nearest = static_cast<int>(i);
    }
  }
  if (nearest < 0) {
    return std::nullopt;
  }
  return Hit{nearest,
             static_cast<float>(best.range),
             static_cast<float>(best.u),
             static_cast<float>(best.v)};
}

}  // namespace deja_view::sim
