// Loops over the lanes of a packet, plain and without branches, which the compiler turns into
// vectors of each instruction set. Operations are not fused or reordered: all give the same bits.
#include "packet_kernel.hpp"

#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "packet_kernel.cpp"
#include "deja_view/base/instruction_sets-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace deja_view::sim::HWY_NAMESPACE {
namespace {

// Neighbouring faces of a box share an edge only up to rounding; this closes the crack [m].
constexpr float kSeam = 1e-4F;

inline void Keep(
    bool hit, float range, float u, float v, std::int32_t index, int lane, RayPacket* p) {
  p->range[lane] = hit ? range : p->range[lane];
  p->surface[lane] = hit ? index : p->surface[lane];
  p->u[lane] = hit ? u : p->u[lane];
  p->v[lane] = hit ? v : p->v[lane];
}

template <bool is_disc>
inline void TracePlane(const LocalSurface& s, std::int32_t index, RayPacket* p) {
  const float nx = s.axis_w.x(), ny = s.axis_w.y(), nz = s.axis_w.z();
  const float ux = s.axis_u.x(), uy = s.axis_u.y(), uz = s.axis_u.z();
  const float vx = s.axis_v.x(), vy = s.axis_v.y(), vz = s.axis_v.z();
  const float offset_u = s.offset_u, offset_v = s.offset_v, offset_w = s.offset_w;
  const float size_u = s.size_u, size_v = s.size_v;
  const float per_u = 2.0F / size_u, per_v = 2.0F / size_v;
  for (int i = 0; i < RayPacket::kSize; ++i) {
    const float x = p->x[i], y = p->y[i], z = p->z[i];
    const float range = -offset_w / (nx * x + ny * y + nz * z);
    const float u = offset_u + range * (ux * x + uy * y + uz * z);
    const float v = offset_v + range * (vx * x + vy * y + vz * z);
    bool hit = (range > 0.0F) & (range < p->range[i]);
    if (is_disc) {
      const float a = u * per_u - 1.0F, b = v * per_v - 1.0F;
      hit &= a * a + b * b <= 1.0F;
    } else {
      hit &= (u >= -kSeam) & (u <= size_u + kSeam) & (v >= -kSeam) & (v <= size_v + kSeam);
    }
    Keep(hit, range, u, v, index, i, p);
  }
}

/// Nearer root as in HitMantle, in the form that keeps its digits for a thin cylinder far away: the
/// foot of the perpendicular is computed first (Haines et al., Ray Tracing Gems, 2019, ch. 7).
inline void TraceMantle(const LocalSurface& s, std::int32_t index, RayPacket* p) {
  const float ax = s.axis_v.x(), ay = s.axis_v.y(), az = s.axis_v.z();
  const float wx = s.across.x(), wy = s.across.y(), wz = s.across.z();
  const float offset_v = s.offset_v, size_v = s.size_v;
  const float radius_squared = s.radius * s.radius;
  for (int i = 0; i < RayPacket::kSize; ++i) {
    const float along = ax * p->x[i] + ay * p->y[i] + az * p->z[i];
    const float dx = p->x[i] - along * ax, dy = p->y[i] - along * ay, dz = p->z[i] - along * az;
    const float inverse = 1.0F / (dx * dx + dy * dy + dz * dz);
    const float foot = -(wx * dx + wy * dy + wz * dz) * inverse;
    const float lx = wx + foot * dx, ly = wy + foot * dy, lz = wz + foot * dz;
    const float rest = radius_squared - (lx * lx + ly * ly + lz * lz);
    const float range = foot - std::sqrt(rest > 0.0F ? rest * inverse : 0.0F);
    const float v = offset_v + range * along;
    const bool hit = (rest >= 0.0F) & (range > 0.0F) & (range < p->range[i]) & (v >= -kSeam) &
                     (v <= size_v + kSeam);
    Keep(hit, range, 0.0F, v, index, i, p);
  }
}

inline void TraceAll(const LocalSurface* surfaces,
                     const std::vector<std::int32_t>& candidates,
                     RayPacket* packet) {
  packet->range.fill(std::numeric_limits<float>::infinity());
  packet->surface.fill(-1);
  for (const std::int32_t index : candidates) {
    const LocalSurface& s = surfaces[index];
    switch (s.shape) {
      case Shape::kRectangle:
        TracePlane<false>(s, index, packet);
        break;
      case Shape::kDisc:
        TracePlane<true>(s, index, packet);
        break;
      case Shape::kCylinder:
        TraceMantle(s, index, packet);
        break;
    }
  }
}

}  // namespace
}  // namespace deja_view::sim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace deja_view::sim {

HWY_EXPORT(TraceAll);

void TracePacket(const LocalSurface* surfaces,
                 const std::vector<std::int32_t>& candidates,
                 RayPacket* packet) {
  HWY_DYNAMIC_DISPATCH(TraceAll)(surfaces, candidates, packet);
}

}  // namespace deja_view::sim
#endif
