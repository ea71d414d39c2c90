#pragma once

#include "deja_view/nerf/device.hpp"
#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/nerf/scene_box.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <cstddef>
#include <memory>
#include <vector>

namespace deja_view::nerf {

/// What one training step did.
struct StepReport {
  std::size_t rays = 0;
  std::size_t samples = 0;   ///< whose density was evaluated
  std::size_t weighted = 0;  ///< of which had weight, and a colour
  double psnr_db = 0;        ///< over the step's rays
};

/// Trains a field on posed images with Adam. The same images, options and calls give the same bits
/// on any number of threads of the CPU, and on one card where options.deterministic is set.
class Trainer {
 public:
  /// Throws CheckError for invalid options, InputError for views that can't be trained on (none,
  /// sizes that differ from their cameras', grey and colour mixed, poses that are not finite). With
  /// a card, all calls may throw DeviceError.
  Trainer(const TrainOptions& options,
          std::vector<TrainingView> views,
          const SceneBox& box,
          const DeviceChoice& device = {});
  /// Goes on with a field that was trained before, on the same images (known by their names) or
  /// others of the same scene; options.field is not looked at. Adam's moments start anew. Throws
  /// also when the images' channels are not the field's.
  Trainer(const TrainOptions& options,
          std::vector<TrainingView> views,
          RadianceField field,
          const DeviceChoice& device = {});
  ~Trainer();
  Trainer(Trainer&&) noexcept;
  Trainer& operator=(Trainer&&) noexcept;

  /// One batch of rays. `progress`, from 0 to 1, sets the learning rates and is kept in the field.
  StepReport Step(double progress);

  /// Says of which sub-map the field is; training does not depend on it.
  void SetCells(SceneCells cells);

  /// Says where the training poses' frame lies; training does not depend on it.
  void SetFrame(const FieldFrame& frame);

  /// The field as it is now; it changes with the next Step. From a card it is fetched by this call.
  const RadianceField& field() const;

  /// The most that was held of a card's memory; 0 on the CPU.
  std::size_t device_bytes() const;

  /// Hands the field over; the trainer is then of no more use.
  RadianceField TakeField() &&;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deja_view::nerf
