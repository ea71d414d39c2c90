#pragma once

#include "deja_view/lab/sim/ray_packet.hpp"

#include <array>
#include <cstdint>

namespace deja_view::sim {

/// A number for each ray of a packet.
using Lanes = std::array<float, RayPacket::kSize>;

/// Seen more flatly than this, a surface is filtered as if it were at this angle.
inline constexpr float kLeastCosine = 0.05F;

/// A surface with everything per metre worked out.
struct ShadedSurface {
  float emission = 0;
  float periods_per_u = 0, periods_per_v = 0;  ///< [1/m]
  float origin_u = 0, origin_v = 0;            ///< [periods]
  float texels_per_range = 0;  ///< width of a ray's footprint [texels] per metre, seen squarely
  std::int32_t texture_size = 0;
  std::int32_t last_level = 0;
  const std::uint32_t* texels = nullptr;
  const std::int32_t* level_offsets = nullptr;
  float light_per_u = 0, light_per_v = 0;  ///< light map cells per metre
  std::int32_t light_width = 0, light_height = 0;
  const float* light = nullptr;
};

}  // namespace deja_view::sim
