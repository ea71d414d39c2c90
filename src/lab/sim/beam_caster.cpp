#include "deja_view/lab/sim/beam_caster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packet_kernel.hpp"

namespace deja_view::sim {
namespace {

/// Unit normal of the plane through the origin, `a` and `b`, away from `inside`.
Eigen::Vector3f OutsideOf(const Eigen::Vector3f& a,
                          const Eigen::Vector3f& b,
                          const Eigen::Vector3f& inside) {
  const Eigen::Vector3f normal = a.cross(b);
  const float length = normal.norm();
  if (length < 1e-6F) {
    return Eigen::Vector3f::Zero();
  }
  return normal.dot(inside) > 0 ? Eigen::Vector3f(-normal / length)
                                : Eigen::Vector3f(normal / length);
}

bool PrepareRectangle(LocalSurface* s) {
  if (!(s->offset_w > 0)) {
    return false;  // seen from behind
  }
  const Eigen::Vector3f u = s->size_u * s->axis_u;
  const Eigen::Vector3f v = s->size_v * s->axis_v;
  const Eigen::Vector3f corner = -s->from_surface;
  const std::array<Eigen::Vector3f, 4> corners = {corner, corner + u, corner + u + v, corner + v};
  const Eigen::Vector3f middle = corner + 0.5F * (u + v);
  for (std::size_t i = 0; i < 4; ++i) {
    s->outside[i] = OutsideOf(corners[i], corners[(i + 1) % 4], middle);
  }
  return true;
}

/// Planes along the two silhouette lines of the mantle and over its upper and lower rim.
bool PrepareCylinder(LocalSurface* s) {
  s->across = s->from_surface - s->offset_v * s->axis_v;
  const float distance = s->across.norm();
  if (!(distance > s->radius)) {
    return false;  // inside, or right above or below
  }
  const Eigen::Vector3f ahead = -s->across / distance;
  const Eigen::Vector3f side = s->axis_v.cross(ahead);
  const float sine = s->radius / distance;
  const float cosine = std::sqrt(1.0F - sine * sine);
  s->outside[0] = -sine * ahead + cosine * side;
  s->outside[1] = -sine * ahead - cosine * side;
  const auto rim = [&](float height, float sign) {
    const float reach = distance + (sign * height > 0 ? -s->radius : s->radius);
    return Eigen::Vector3f((sign * (reach * s->axis_v - height * ahead)).normalized());
  };
  s->outside[2] = rim(s->size_v - s->offset_v, 1.0F);
  s->outside[3] = rim(-s->offset_v, -1.0F);
  return true;
}

}  // namespace

Cone BoundingCone(const std::vector<Eigen::Vector3f>& directions, float margin) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const auto& direction : directions) {
    sum += direction;
  }
  Cone cone{sum.normalized(), 0};
  float half_angle = 0;
  for (const auto& direction : directions) {
    // atan2 keeps its precision at small angles, where acos has none.
    half_angle = std::max(half_angle,
                          std::atan2(cone.axis.cross(direction).norm(), cone.axis.dot(direction)));
  }
  cone.sin_half_angle = std::sin(std::min(half_angle + margin, 1.5707F));
  return cone;
}

BeamCaster::BeamCaster(const Scene& scene, const Rigid3& T_W_A)
    : origin_(T_W_A.t.cast<float>()), local_(scene.surfaces.size()) {
  const Eigen::Matrix3f R_A_W = T_W_A.R().transpose().cast<float>();
  for (std::size_t i = 0; i < local_.size(); ++i) {
    const Surface& surface = scene.surfaces[i];
    LocalSurface& s = local_[i];
    s.shape = surface.shape;
    s.axis_u = R_A_W * surface.axis_u;
    s.axis_v = R_A_W * surface.axis_v;
    s.axis_w = R_A_W * surface.Normal();
    s.from_surface = R_A_W * (T_W_A.t - surface.origin.cast<double>()).cast<float>();
    s.offset_u = s.from_surface.dot(s.axis_u);
    s.offset_v = s.from_surface.dot(s.axis_v);
    s.offset_w = s.from_surface.dot(s.axis_w);
    s.size_u = surface.size_u;
    s.size_v = surface.size_v;
    s.radius = surface.Radius();
    const bool faces = s.shape == Shape::kCylinder ? PrepareCylinder(&s) : PrepareRectangle(&s);
    if (faces) {
      visible_.push_back(static_cast<std::int32_t>(i));
    }
  }
}

void BeamCaster::Cull(const Cone& cone,
                      const std::vector<std::int32_t>& candidates,
                      std::vector<std::int32_t>* inside) const {
  inside->clear();
  for (const std::int32_t index : candidates) {
    const auto& planes = local_[static_cast<std::size_t>(index)].outside;
    const float farthest = std::max(std::max(planes[0].dot(cone.axis), planes[1].dot(cone.axis)),
                                    std::max(planes[2].dot(cone.axis), planes[3].dot(cone.axis)));
    if (farthest <= cone.sin_half_angle) {
      inside->push_back(index);
    }
  }
}

void BeamCaster::Trace(const std::vector<std::int32_t>& candidates, RayPacket* packet) const {
  TracePacket(local_.data(), candidates, packet);
}

void BeamCaster::Complete(RayPacket* packet) const {
  packet->origin = origin_;
  for (int i = 0; i < RayPacket::kSize; ++i) {
    if (packet->surface[i] < 0) {
      continue;
    }
    const LocalSurface& s = local_[static_cast<std::size_t>(packet->surface[i])];
    const Eigen::Vector3f direction(packet->x[i], packet->y[i], packet->z[i]);
    if (s.shape != Shape::kCylinder) {
      packet->cosine[i] = -s.axis_w.dot(direction);
      continue;
    }
    const Eigen::Vector3f p = s.from_surface + packet->range[i] * direction;
    const Eigen::Vector3f from_axis = p - p.dot(s.axis_v) * s.axis_v;
    packet->cosine[i] = -from_axis.dot(direction) / s.radius;
    // axis_w is -axis_v x axis_u.
    const float angle = std::atan2(-p.dot(s.axis_w), p.dot(s.axis_u));
    packet->u[i] = (angle < 0 ? angle + 6.2831853F : angle) * s.radius;
  }
}

}  // namespace deja_view::sim
