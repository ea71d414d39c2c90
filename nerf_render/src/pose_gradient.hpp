#pragma once

#include <vector>

#include "backward.hpp"
#include "place_gradient.hpp"

namespace deja_view::nerf::internal {

/// Per ray, from the derivatives of the features that its samples read. Where samples lie along the
/// ray, and which of them bear weight, is held fixed.
void ComputePoseGradients(const RadianceField& field,
                          const std::vector<Ray>& rays,
                          const Trace& trace,
                          const ChunkGradient& gradient,
                          std::vector<PoseGradient>* poses);

}  // namespace deja_view::nerf::internal
