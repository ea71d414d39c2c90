#include "deja_view/nerf/feature_grid.hpp"

#include "deja_view/base/random.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace deja_view::nerf {
namespace {

// Cells that a side needs, the last corner included, in bricks of two.
std::uint64_t Bricks(float extent, float scale) {
  return static_cast<std::uint64_t>(extent * scale) / 2 + 2;
}

}  // namespace

FeatureGrid::FeatureGrid(const GridOptions& options,
                         const Eigen::Vector3f& extent,
                         std::uint64_t seed) {
  const std::uint64_t table_bricks = (std::uint64_t{1} << options.log2_table_size) / 8;
  const double growth =
      options.levels > 1
          ? std::pow(static_cast<double>(options.finest_resolution) / options.base_resolution,
                     1.0 / (options.levels - 1))
          : 1.0;
  std::size_t offset = 0;
  for (int l = 0; l < options.levels; ++l) {
    GridLevel level;
    level.scale = static_cast<float>(options.base_resolution * std::pow(growth, l));
    level.features = options.features;
    level.offset = offset;
    const std::uint64_t bx = Bricks(extent.x(), level.scale);
    const std::uint64_t by = Bricks(extent.y(), level.scale);
    const std::uint64_t bz = Bricks(extent.z(), level.scale);
    level.hashed = bx * by * bz > table_bricks;
    level.bricks = static_cast<std::uint32_t>(level.hashed ? table_bricks : bx * by * bz);
    if (level.hashed) {
      level.mask = level.bricks - 1;
    } else {
      level.stride_y = static_cast<std::uint32_t>(bx);
      level.stride_z = static_cast<std::uint32_t>(bx * by);
    }
    offset += std::size_t{8} * level.bricks * static_cast<std::size_t>(options.features);
    levels_.push_back(level);
  }
  outputs_ = options.levels * options.features;
  parameters_ = FloatArray(offset);
  Random random(seed, 0);
  for (std::size_t i = 0; i < offset; ++i) {
    parameters_[i] = (random.UniformFloat() - 0.5F) * 2e-4F;
  }
}

void FeatureGrid::Forward(const Kernels& kernels,
                          const Positions& p,
                          std::size_t count,
                          std::size_t stride,
                          float* rows) const {
  std::size_t column = 0;
  for (const GridLevel& level : levels_) {
    kernels.grid_forward(level, parameters_.data() + level.offset, p, count, rows + column, stride);
    column += static_cast<std::size_t>(level.features);
  }
  for (std::size_t s = 0; s < count && column < stride; ++s) {
    std::fill_n(rows + s * stride + column, stride - column, 0.0F);
  }
}

}  // namespace deja_view::nerf
