#include "grid_optimizer.hpp"

#include <cstring>

namespace deja_view::nerf::internal {

GridOptimizer::GridOptimizer(const FeatureGrid& grid)
    : gradient_(grid.parameters().size()),
      first_(grid.parameters().size()),
      second_(grid.parameters().size()) {
  for (const GridLevel& level : grid.levels()) {
    touched_.emplace_back((std::size_t{level.bricks} + 7) / 8 * 8, std::uint8_t{0});
  }
}

void GridOptimizer::Update(std::size_t level,
                           const std::vector<ChunkGradient>& chunks,
                           GridGradient ChunkGradient::*part,
                           const AdamStep& step,
                           const Kernels& kernels,
                           FeatureGrid* grid) {
  const GridLevel& shape = grid->levels()[level];
  std::vector<std::uint8_t>& touched = touched_[level];
  for (const ChunkGradient& chunk : chunks) {
    const GridGradient& samples = chunk.*part;
    if (samples.size() == 0) {
      continue;
    }
    kernels.grid_backward(shape,
                          samples.positions(),
                          samples.size(),
                          samples.levels[level].data(),
                          gradient_.data() + shape.offset,
                          touched.data());
  }
  const std::size_t brick = std::size_t{8} * static_cast<std::size_t>(shape.features);
  for (std::size_t group = 0; group < touched.size(); group += 8) {
    std::uint64_t any = 0;
    std::memcpy(&any, touched.data() + group, 8);
    if (any == 0) {
      continue;
    }
    for (std::size_t b = group; b < group + 8; ++b) {
      if (touched[b] != 0) {
        const std::size_t at = shape.offset + b * brick;
        kernels.adam(step,
                     brick,
                     grid->parameters().data() + at,
                     gradient_.data() + at,
                     first_.data() + at,
                     second_.data() + at);
        touched[b] = 0;
      }
    }
  }
}

}  // namespace deja_view::nerf::internal
