#pragma once

#include "deja_view/lab/sim/scene.hpp"

#include <array>
#include <cstdint>

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
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();  ///< of the rays [m] in W; by Complete
};

/// A surface as seen from the origin of the rays, in frame A.
struct LocalSurface {
  Shape shape = Shape::kRectangle;
  Eigen::Vector3f axis_u, axis_v, axis_w;  ///< axis_w = axis_u x axis_v
  Eigen::Vector3f from_surface;  ///< the origin of A as seen from surface.origin, in A [m]
  Eigen::Vector3f across;        ///< cylinder: from_surface without its part along the axis
  float offset_u = 0, offset_v = 0, offset_w = 0;  ///< from_surface along the three axes
  float size_u = 0, size_v = 0, radius = 0;
  std::array<Eigen::Vector3f, 4> outside;  ///< unit normals of the planes about it; 0: none
};

}  // namespace deja_view::sim
