#pragma once

#include "ray_loss.hpp"

namespace deja_view::nerf::internal {

/// Derivatives of the features that samples read from one grid, which GridOptimizer carries on to
/// the grid's entries.
struct GridGradient {
  std::vector<float> x, y, z;              ///< positions of the samples
  std::vector<std::vector<float>> levels;  ///< per level: n x features

  std::size_t size() const { return x.size(); }
  Positions positions() const { return {x.data(), y.data(), z.data()}; }
};

/// Derivatives of one chunk of rays; the networks' are complete.
struct ChunkGradient {
  GridGradient geometry;
  GridGradient appearance;
  GridGradient background;  ///< a sample per ray; empty without far background
  std::vector<float> density_network;
  std::vector<float> color_network;
  std::vector<float> background_network;
  std::vector<float> latent;  ///< rays x latent_size
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
