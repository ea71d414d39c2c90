#pragma once

#include "deja_view/lab/sim/texture.hpp"

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace deja_view::sim {

enum class Shape : std::uint8_t { kRectangle, kDisc, kCylinder };

/// A surface, seen from the side its normal points to only.
///   kRectangle  origin + u axis_u + v axis_v, u in [0, size_u], v in [0, size_v]
///   kDisc       the ellipse inscribed in that rectangle
///   kCylinder   the mantle about axis_v through `origin`, radius size_u / (2 pi), height size_v; u
///   runs
///               around it, from the direction axis_u towards axis_v x axis_u
struct Surface {
  Shape shape = Shape::kRectangle;
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();   ///< [m] in W
  Eigen::Vector3f axis_u = Eigen::Vector3f::UnitX();  ///< unit
  Eigen::Vector3f axis_v = Eigen::Vector3f::UnitY();  ///< unit, orthogonal to axis_u
  float size_u = 1;                                   ///< [m]
  float size_v = 1;                                   ///< [m]

  int texture = 0;                                           ///< index in Scene::textures
  Eigen::Vector2f period = Eigen::Vector2f::Ones();          ///< [m] per period of the texture
  Eigen::Vector2f texture_origin = Eigen::Vector2f::Zero();  ///< [periods] at u = v = 0
  float emission = 0;  ///< own radiance; > 0: a lamp or window
  float gloss = 0;     ///< share of light mirrored, seen squarely; 0: matt

  int light_u = 0;  ///< size of the baked light map, set by BakeLight
  int light_v = 0;
  std::size_t light_offset = 0;

  Eigen::Vector3f Normal() const { return axis_u.cross(axis_v); }  ///< of a rectangle or disc
  float Radius() const { return size_u * 0.15915494F; }            ///< of a cylinder
  Eigen::Vector3f Point(float u, float v) const;                   ///< (u, v) [m] to W
  Eigen::Vector3f NormalAt(float u) const;                         ///< unit, outwards, in W
};

/// First surface that a ray meets.
struct Hit {
  int surface = -1;
  float range = 0;  ///< [m] along the unit ray
  float u = 0;      ///< [m] on the surface
  float v = 0;
};

struct Scene {
  std::vector<Texture> textures;
  std::vector<Surface> surfaces;
  std::vector<float> light;  ///< baked irradiance of all light maps
};

/// Nearest hit of the ray from `origin` along the unit vector `direction` (both in W), in double
/// precision and without any acceleration: the reference for the packet kernels, and for few rays.
std::optional<Hit> CastRay(const Scene& scene,
                           const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction);

}  // namespace deja_view::sim
