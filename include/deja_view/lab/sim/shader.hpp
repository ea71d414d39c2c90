#pragma once

#include "deja_view/lab/sim/beam_caster.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace deja_view::sim {

/// Radiance of hits: reflectance from the mip-mapped texture times baked light, or the surface's
/// own light. Works on whole packets, surface by surface.
class Shader {
 public:
  using Lanes = std::array<float, RayPacket::kSize>;

  /// Keeps a reference to `scene`, whose light must be baked. `sample_angle` [rad]: what one ray
  /// stands for; the wider, the coarser the texture level.
  Shader(const Scene& scene, float sample_angle);

  /// Radiance of each ray of a completed packet; 0 where nothing is hit.
  Lanes Shade(const RayPacket& packet) const;

  /// Shade without vector instructions beyond the baseline; gives the same bits.
  Lanes ShadePortable(const RayPacket& packet) const;

  /// One ray by Texture::Sample and SampleLight, the reference.
  float ShadeOne(const RayPacket& packet, int lane) const;

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

 private:
  const Scene& scene_;
  float sample_angle_;
  std::vector<ShadedSurface> surfaces_;
};

}  // namespace deja_view::sim
