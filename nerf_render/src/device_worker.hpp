#pragma once

#include "deja_view/nerf/device.hpp"

#include <memory>
#include <vector>

#include "device_batches.hpp"
#include "device_engine.hpp"
#include "occupancy_update.hpp"
#include "step_worker.hpp"

namespace deja_view::nerf::internal {

/// Trains on a card. What belongs to images stays with the trainer, and goes to the card before a
/// step and comes back as gradients behind it.
class DeviceWorker final : public StepWorker {
 public:
  /// Takes field and images to the card. All references but `views` and `occupancy` must live on.
  /// Throws DeviceError, as do all calls.
  DeviceWorker(const DeviceChoice& device,
               const TrainOptions& options,
               const std::vector<TrainingView>& views,
               const ImageParameters& image_parameters,
               const OccupancyUpdate& occupancy,
               RadianceField* field);

  StepSums RunRays(const StepPlan& plan, std::vector<ImageGradient>* images) override;
  void UpdateField(float rate) override;
  void UpdateOccupancy(std::uint64_t round, bool full) override;
  void Download() override;
  std::size_t DeviceBytes() const override { return engine_->PeakBytes(); }

 private:
  ImageState MakeState() const;
  StepSums AddRays(const StepPlan& plan, std::vector<ImageGradient>* images);

  const ImageParameters& image_parameters_;
  RadianceField& field_;
  std::size_t views_;
  std::unique_ptr<DeviceEngine> engine_;
  DeviceBatches batches_;
  bool is_field_old_ = false;
};

}  // namespace deja_view::nerf::internal
