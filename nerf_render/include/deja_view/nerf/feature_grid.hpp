#pragma once

#include "deja_view/nerf/float_array.hpp"
#include "deja_view/nerf/kernel_table.hpp"
#include "deja_view/nerf/options.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view::nerf {

/// The levels of a grid and their parameters. Positions are in unit coordinates, from 0 to `extent`
/// (at most 1) on each axis.
class FeatureGrid {
 public:
  FeatureGrid() = default;
  /// Level l has base (finest / base)^(l / (levels - 1)) cells along a unit length. Parameters
  /// start at small random values.
  FeatureGrid(const GridOptions& options, const Eigen::Vector3f& extent, std::uint64_t seed);

  const std::vector<GridLevel>& levels() const { return levels_; }
  int outputs() const { return outputs_; }  ///< levels x features

  FloatArray& parameters() { return parameters_; }
  const FloatArray& parameters() const { return parameters_; }

  /// Writes the features of `count` samples to rows that are `stride` floats apart, and 0 behind
  /// them.
  void Forward(const Kernels& kernels,
               const Positions& p,
               std::size_t count,
               std::size_t stride,
               float* rows) const;

 private:
  std::vector<GridLevel> levels_;
  int outputs_ = 0;
  FloatArray parameters_;
};

}  // namespace deja_view::nerf
