#pragma once

#include "deja_view/lab/sim/ray_packet.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::sim {

/// See BeamCaster::Trace. The fast one needs AVX2 (HasAvx2). Both run the same operations in the
/// same order, without fusing, on more or fewer lanes at a time: the same bits.
void TracePacketFast(const LocalSurface* surfaces,
                     const std::vector<std::int32_t>& candidates,
                     RayPacket* packet);
void TracePacketPortable(const LocalSurface* surfaces,
                         const std::vector<std::int32_t>& candidates,
                         RayPacket* packet);

}  // namespace deja_view::sim
