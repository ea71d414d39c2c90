#pragma once

#include "ray_loss.hpp"

namespace deja_view::nerf::internal {

/// Derivatives of one chunk of rays: complete for the networks; for the grids, those of the
/// features that each sample read, which ApplyGridGradients carries on.
struct ChunkGradient {
  std::vector<float> x, y, z;                       ///< positions of the samples
  std::vector<std::vector<float>> geometry_levels;  ///< per level: n x features
  std::vector<std::vector<float>> appearance_levels;
  std::vector<float> density_network;
  std::vector<float> color_network;

  std::size_t size() const { return x.size(); }
  Positions positions() const { return {x.data(), y.data(), z.data()}; }
};

/// Working memory of Backpropagate.
struct BackwardScratch {
  Network::Activations density_activations;
  std::vector<float> d_out;
  std::vector<float> d_rows;
};

/// Carries the loss' derivatives through both networks.
void Backpropagate(const RadianceField& field,
                   const Kernels& kernels,
                   const LossGradient& loss,
                   Trace* trace,
                   BackwardScratch* scratch,
                   ChunkGradient* gradient);

}  // namespace deja_view::nerf::internal
