#pragma once

#include <cstdint>
#include <vector>

#include "backward.hpp"

namespace deja_view::nerf::internal {

/// Adam's state of a grid, and the pass that carries gradients from samples to entries.
///
/// Levels are independent of each other, so that threads share them out without locks; each goes
/// through all samples in order, hence the same sums on any number of threads. Only bricks that
/// samples touched are updated.
class GridOptimizer {
 public:
  explicit GridOptimizer(const FeatureGrid& grid);

  std::size_t levels() const { return touched_.size(); }

  /// Gradient of level `level` from all chunks, then an Adam step on what they touched. `part`
  /// picks the grid's from a chunk. Calls for different levels may run at the same time.
  void Update(std::size_t level,
              const std::vector<ChunkGradient>& chunks,
              GridGradient ChunkGradient::*part,
              const AdamStep& step,
              const Kernels& kernels,
              FeatureGrid* grid);

 private:
  FloatArray gradient_;
  FloatArray first_;
  FloatArray second_;
  std::vector<std::vector<std::uint8_t>> touched_;  ///< per level and brick, padded to eight
};

}  // namespace deja_view::nerf::internal
