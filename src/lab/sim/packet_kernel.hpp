#pragma once

#include "deja_view/lab/sim/ray_packet.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::sim {

/// See BeamCaster::Trace. The same bits on every instruction set.
void TracePacket(const LocalSurface* surfaces,
                 const std::vector<std::int32_t>& candidates,
                 RayPacket* packet);

}  // namespace deja_view::sim
