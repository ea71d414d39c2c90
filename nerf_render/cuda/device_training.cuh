#pragma once

#include <memory>

#include "device_images.cuh"
#include "device_optimizer.cuh"
#include "device_tracer.cuh"
#include "training.cuh"

namespace deja_view::nerf::internal {

/// A step's work on a device: what CpuWorker does.
template <typename System>
class DeviceTraining {
 public:
  DeviceTraining(const TrainOptions& options, const TrainingSet& set, DeviceField<System>* field)
      : options_(options), field_(*field), images_(set, options) {
    geometry_.Start(field->geometry, options.deterministic);
    appearance_.Start(field->appearance, options.deterministic);
    density_.Start(field->density.values.size());
    color_.Start(field->color.values.size());
    if (field->has_background()) {
      background_.Start(field->background, options.deterministic);
      background_color_.Start(field->background_color.values.size());
    }
  }

  void SetImages(const ImageState& state) { images_.Set(state); }

  StepSums AddRays(const StepPlan& plan, std::size_t first, std::size_t count, RayGradients* out) {
    images_.Draw(plan, first, count, field_.layout, &work_->tracer.rays, &work_->targets);
    work_->tracer.Run(plan.trace, &field_);
    FindLoss();
    StepSums sums;
    sums.samples = work_->tracer.CountEvaluated();
    sums.weighted = work_->tracer.sample_count();
    for (const float error : work_->squared_error.Download()) {
      sums.squared_error += static_cast<double>(error);
    }
    sums.color_values = count * field_.channels();
    out->targets = work_->targets.Download();
    out->d_exposure = work_->d_exposure.Download();
    CarryToColor(out);
    CarryToDensity();
    return sums;
  }

  void UpdateField(float rate) {
    const AdamStep grid_step = GridStep(options_, rate);
    geometry_.Update(grid_step, &field_.geometry);
    appearance_.Update(grid_step, &field_.appearance);
    if (field_.has_background()) {
      background_.Update(grid_step, &field_.background);
    }
    AdamStep step;
    step.learning_rate = rate * options_.network_learning_rate;
    density_.Update(step, &field_.density.values);
    color_.Update(step, &field_.color.values);
    if (field_.has_background()) {
      background_color_.Update(step, &field_.background_color.values);
    }
  }

  /// Gives back what rays took.
  void Release() {
    work_ = std::make_unique<Work>();
    for (auto* grid : {&geometry_, &appearance_, &background_}) {
      grid->Release();
    }
  }
  void DropGradients() {
    for (auto* grid : {&geometry_, &appearance_, &background_}) {
      grid->DropGradient();
    }
    for (auto* network : {&density_, &color_, &background_color_}) {
      network->gradient.Clear();
    }
  }

 private:
  /// What rays take.
  struct Work {
    DeviceTracer<System> tracer;
    DeviceArray<System, RayTarget> targets;
    DeviceArray<System, GainBias> d_exposure;
    DeviceArray<System, float> squared_error, d_weight, d_raw, d_color, d_background, d_latent;
    DeviceArray<System, float> rows, d_out, d_rows, d_appearance;
    BackwardRows<System> scratch;
  };

  void FindLoss() {
    const std::size_t rays = work_->tracer.ray_count();
    const std::size_t samples = work_->tracer.sample_count();
    LossOfRays loss;
    loss.loss.trace = work_->tracer.View(field_);
    loss.loss.targets = work_->targets.data();
    loss.loss.exposures = images_.gain_bias();
    loss.loss.options = {
        options_.huber_delta, options_.depth_weight, options_.distortion_weight, options_.opaque};
    LossRows& rows = loss.loss.out;
    rows.color_stride = field_.color.outputs();
    work_->d_weight.ResizeToZeros(samples);
    work_->d_raw.Resize(samples);
    work_->d_color.ResizeToZeros(samples * rows.color_stride);
    work_->d_exposure.ResizeToZeros(rays);
    work_->squared_error.Resize(rays);
    if (field_.has_background()) {
      rows.background_stride = field_.background_color.outputs();
      work_->d_background.ResizeToZeros(rays * rows.background_stride);
    }
    rows.d_weight = work_->d_weight.data();
    rows.d_raw = work_->d_raw.data();
    rows.d_color_rows = work_->d_color.data();
    rows.d_background_rows = work_->d_background.data();
    rows.d_exposure = work_->d_exposure.data();
    loss.squared_error = work_->squared_error.data();
    ForEach<System>(rays, loss);
  }

  void CarryToColor(RayGradients* out) {
    const std::size_t samples = work_->tracer.sample_count();
    const FinishRow ends = work_->tracer.RowEnds(field_);
    work_->d_appearance.Resize(samples * ends.stride);
    field_.color.Backward(work_->tracer.color_rows.data(),
                          work_->d_color.data(),
                          samples,
                          &work_->scratch,
                          color_.gradient.data(),
                          work_->d_appearance.data());
    appearance_.Add(field_.appearance,
                    work_->tracer.places(),
                    work_->d_appearance.data(),
                    ends.stride,
                    samples);
    const std::size_t size = field_.latent_size();
    work_->d_latent.Resize(work_->tracer.ray_count() * size);
    ForEach<System>(work_->d_latent.size(),
                    SumLatents{work_->tracer.ray_begin.data(),
                               work_->d_appearance.data(),
                               ends.stride,
                               ends.LatentColumn(),
                               size,
                               work_->d_latent.data()});
    out->d_latent = work_->d_latent.Download();
    if (field_.has_background()) {
      CarryToBackground();
    }
  }

  void CarryToBackground() {
    const std::size_t rays = work_->tracer.ray_count();
    const std::size_t stride = field_.background_color.inputs();
    work_->d_rows.Resize(rays * stride);
    field_.background_color.Backward(work_->tracer.background_rows.data(),
                                     work_->d_background.data(),
                                     rays,
                                     &work_->scratch,
                                     background_color_.gradient.data(),
                                     work_->d_rows.data());
    background_.Add(
        field_.background, work_->tracer.background_places(), work_->d_rows.data(), stride, rays);
  }

  void CarryToDensity() {
    const std::size_t samples = work_->tracer.sample_count();
    const std::size_t stride = field_.density.inputs();
    const GridView grid = field_.geometry.view();
    work_->rows.Resize(samples * stride);
    ForEach<System>(samples * grid.level_count,
                    EncodeLevel{grid, work_->tracer.places(), work_->rows.data(), stride});
    FinishRow ends;
    ends.rows = work_->rows.data();
    ends.stride = stride;
    ends.features = field_.geometry.outputs();
    ForEach<System>(samples, ends);
    field_.density.ForwardHidden(work_->rows.data(), samples);
    work_->d_out.Resize(samples * field_.density.outputs());
    ForEach<System>(samples,
                    FirstOfRow{work_->d_raw.data(), field_.density.outputs(), work_->d_out.data()});
    work_->d_rows.Resize(samples * stride);
    field_.density.Backward(work_->rows.data(),
                            work_->d_out.data(),
                            samples,
                            &work_->scratch,
                            density_.gradient.data(),
                            work_->d_rows.data());
    geometry_.Add(field_.geometry, work_->tracer.places(), work_->d_rows.data(), stride, samples);
  }

  TrainOptions options_;
  DeviceField<System>& field_;
  DeviceImages<System> images_;
  std::unique_ptr<Work> work_ = std::make_unique<Work>();
  DeviceGridOptimizer<System> geometry_, appearance_, background_;
  DeviceDenseAdam<System> density_, color_, background_color_;
};

}  // namespace deja_view::nerf::internal
