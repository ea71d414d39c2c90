#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view::sim {

/// Rays that share an origin, and what they hit. Unused lanes may hold any finite direction.
struct alignas(64) RayPacket {
  static constexpr int kSize = 16;
  std::array<float, kSize> x{}, y{}, z{};     ///< unit directions in frame A
  std::array<float, kSize> range{};           ///< [m]; infinite where nothing is hit
  std::array<std::int32_t, kSize> surface{};  ///< -1 where nothing is hit
  std::array<float, kSize> u{}, v{};          ///< [m] on the surface; u of a cylinder by Complete
  std::array<float, kSize> cosine{};          ///< between normal and ray back; by Complete
};

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

  /// Trace without vector instructions beyond the baseline; gives the same bits.
  void TracePortable(const std::vector<std::int32_t>& candidates, RayPacket* packet) const;

  /// Fills in what only shading needs: `cosine` of all hits, and `u` of cylinders.
  void Complete(RayPacket* packet) const;

  /// A surface as seen from the origin, in frame A.
  struct LocalSurface {
    Shape shape = Shape::kRectangle;
    Eigen::Vector3f axis_u, axis_v, axis_w;  ///< axis_w = axis_u x axis_v
    Eigen::Vector3f from_surface;  ///< the origin of A as seen from surface.origin, in A [m]
    Eigen::Vector3f across;        ///< cylinder: from_surface without its part along the axis
    float offset_u = 0, offset_v = 0, offset_w = 0;  ///< from_surface along the three axes
    float size_u = 0, size_v = 0, radius = 0;
    std::array<Eigen::Vector3f, 4> outside;  ///< unit normals of the planes about it; 0: none
  };

 private:
  std::vector<LocalSurface> local_;
  std::vector<std::int32_t> visible_;
};

}  // namespace deja_view::sim
