#pragma once

#include "deja_view/lab/sim/beam_caster.hpp"
#include "deja_view/lab/sim/scene.hpp"
#include "deja_view/lab/sim/shaded_surface.hpp"

#include <vector>

namespace deja_view::sim {

/// Radiance of hits: reflectance from the mip-mapped texture times baked light, or the surface's
/// own light. Glossy surfaces mirror lamps and windows, by Schlick's share (An Inexpensive BRDF
/// Model for Physically-based Rendering, 1994). Works on whole packets, surface by surface.
class Shader {
 public:
  using Lanes = sim::Lanes;

  /// Keeps a reference to `scene`, whose light must be baked. `sample_angle` [rad]: what one ray
  /// stands for; the wider, the coarser the texture level.
  Shader(const Scene& scene, float sample_angle);

  /// Radiance of each ray of a completed packet; 0 where nothing is hit.
  Lanes Shade(const RayPacket& packet) const;

  /// One ray by Texture::Sample and SampleLight, the reference.
  float ShadeOne(const RayPacket& packet, int lane) const;

 private:
  /// What a ray sees of lamps and windows in a glossy surface.
  float Mirrored(const RayPacket& packet, int lane) const;

  const Scene& scene_;
  float sample_angle_;
  std::vector<ShadedSurface> surfaces_;
  Scene mirrored_lights_;  ///< lamps and windows, if anything is glossy
};

}  // namespace deja_view::sim
