#pragma once

#include "deja_view/lab/sim/shaded_surface.hpp"

namespace deja_view::sim {

/// See Shader::Shade. The same bits on every instruction set.
void ShadePacket(const ShadedSurface* surfaces, const RayPacket& packet, Lanes* radiance);

}  // namespace deja_view::sim
