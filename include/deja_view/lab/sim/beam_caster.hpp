#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/lab/sim/ray_packet.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view::sim {

/// Directions within `sin_half_angle` of a unit axis in frame A; narrower than a half space.
struct Cone {
  Eigen::Vector3f axis = Eigen::Vector3f::UnitZ();
  float sin_half_angle = 0;
};

/// Smallest cone about the mean direction that holds all of `directions` (unit, in A), widened by
/// `margin` [rad].
Cone BoundingCone(const std::vector<Eigen::Vector3f>& directions, float margin);

/// Casts packets of rays from one point. All that depends on the origin is computed once per
/// surface; whole beams of rays are first culled against the four planes through the origin and a
/// surface's outline, so that a packet meets only the few surfaces within its beam. Frame A is the
/// caller's (the camera's).
class BeamCaster {
 public:
  /// Keeps a reference to `scene`.
  BeamCaster(const Scene& scene, const Rigid3& T_W_A);

  /// Surfaces that face the origin.
  const std::vector<std::int32_t>& visible() const { return visible_; }

  /// Those of `candidates` that the cone may meet (never too few).
  void Cull(const Cone& cone,
            const std::vector<std::int32_t>& candidates,
            std::vector<std::int32_t>* inside) const;

  /// Nearest hits among `candidates`; overwrites range, surface, u and v of the packet.
  void Trace(const std::vector<std::int32_t>& candidates, RayPacket* packet) const;

  /// Fills in what only shading needs: `origin`, `cosine` of all hits, and `u` of cylinders.
  void Complete(RayPacket* packet) const;

 private:
  Eigen::Vector3f origin_;
  std::vector<LocalSurface> local_;
  std::vector<std::int32_t> visible_;
};

}  // namespace deja_view::sim
