#pragma once

#include <cstdint>
#include <vector>

#include "image_parameters.hpp"
#include "step_plan.hpp"

namespace deja_view::nerf::internal {

/// What a training step does to the grids, the networks and the occupancy grid of a field: on the
/// CPU or on a card. The schedule, and what belongs to images, is the trainer's.
class StepWorker {
 public:
  virtual ~StepWorker() = default;

  /// Gathers the gradients of the plan's rays; `images`, one entry per chunk, receives those of
  /// what belongs to images.
  virtual StepSums RunRays(const StepPlan& plan, std::vector<ImageGradient>* images) = 0;
  /// One step of Adam with the gathered gradients; `rate` times the options' learning rates.
  virtual void UpdateField(float rate) = 0;
  /// `round` numbers the random draws; OccupancyUpdate::Run.
  virtual void UpdateOccupancy(std::uint64_t round, bool full) = 0;
  /// Brings the trainer's field up to date.
  virtual void Download() = 0;
  /// The most that was held of a card's memory.
  virtual std::size_t DeviceBytes() const { return 0; }
};

}  // namespace deja_view::nerf::internal
