#pragma once

#include <array>
#include <vector>

#include "backward.hpp"

namespace deja_view::nerf::internal {

/// Derivative of the loss by a camera's pose through one ray: by a shift of the camera in unit
/// lengths along N's axes, then by a rotation vector [rad] about N's axes through the camera.
using PoseGradient = std::array<float, 6>;

/// Per ray, from the derivatives of the features that its samples read. Where samples lie along the
/// ray, and which of them bear weight, is held fixed.
void ComputePoseGradients(const RadianceField& field,
                          const std::vector<Ray>& rays,
                          const Trace& trace,
                          const ChunkGradient& gradient,
                          std::vector<PoseGradient>* poses);

}  // namespace deja_view::nerf::internal
