#pragma once

#include "deja_view/nerf/kernel_table.hpp"
#include "deja_view/nerf/options.hpp"

#include <cstddef>
#include <cstdint>

#include "ray_march.hpp"

namespace deja_view::nerf::internal {

constexpr std::size_t kRaysPerChunk = 256;  ///< that share their random numbers

/// Which rays a step looks at, and how.
struct StepPlan {
  std::uint64_t step = 0;
  std::size_t chunks = 1;  ///< of kRaysPerChunk rays
  TraceOptions trace;
  float depth_share = 0;  ///< of the rays that go through depth points
};

/// What the rays of a step add up to.
struct StepSums {
  std::size_t samples = 0;   ///< whose density was evaluated
  std::size_t weighted = 0;  ///< of which had weight
  double squared_error = 0;
  std::size_t color_values = 0;  ///< terms of squared_error

  void Add(const StepSums& other) {
    samples += other.samples;
    weighted += other.weighted;
    squared_error += other.squared_error;
    color_values += other.color_values;
  }
};

/// Of the grids' features, at a share of their learning rate.
inline AdamStep GridStep(const TrainOptions& options, float rate) {
  AdamStep step;
  step.learning_rate = rate * options.grid_learning_rate;
  step.epsilon = options.grid_epsilon;
  step.decay = options.grid_decay;
  return step;
}

}  // namespace deja_view::nerf::internal
