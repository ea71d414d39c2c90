#include "deja_view/nerf/trainer.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/nerf/kernels.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "cpu_worker.hpp"
#include "device_worker.hpp"
#include "training_views.hpp"

namespace deja_view::nerf {
namespace {

using internal::CheckViews;
using internal::CpuWorker;
using internal::DeviceWorker;
using internal::ImageGradient;
using internal::kRaysPerChunk;
using internal::StepPlan;
using internal::StepSums;
using internal::StepWorker;

constexpr double kWantedSamples = 28;  ///< per ray, at most, where coarser steps can bring it about
constexpr double kMaxStepFactor = 8;

}  // namespace

class Trainer::Impl {
 public:
  Impl(const TrainOptions& options,
       std::vector<TrainingView> views,
       RadianceField field,
       const DeviceChoice& device)
      : options_(options),
        views_(std::move(views)),
        kernels_(FindKernels(options.kernels)),
        field_(std::move(field)),
        occupancy_(views_, options.threads, options.carve_votes, &field_),
        image_parameters_(options_, views_, &field_),
        worker_(MakeWorker(device)) {
    if (field_.progress > 0) {
      // What was learnt tells where matter is; there is nothing to warm up.
      step_ = static_cast<std::uint64_t>(options_.warmup_steps);
      step_factor_ = std::max(1.0F, field_.march.min_step / options_.march.min_step);
      worker_->UpdateOccupancy(step_, true);
    }
  }

  StepReport Step(double progress) {
    StepPlan plan;
    plan.step = step_;
    plan.chunks = std::max<std::size_t>(1, rays_ / kRaysPerChunk);
    plan.trace = {options_.march, step_factor_};
    plan.depth_share =
        options_.depth_share + static_cast<float>(std::clamp(progress, 0.0, 1.0)) *
                                   (options_.final_depth_share - options_.depth_share);
    const StepSums sums = worker_->RunRays(plan, &images_);
    const double decay =
        std::clamp((progress - static_cast<double>(options_.decay_start)) /
                       std::max(1e-6, 1 - static_cast<double>(options_.decay_start)),
                   0.0,
                   1.0);
    const auto rate =
        static_cast<float>(std::pow(static_cast<double>(options_.final_learning_rate), decay));
    worker_->UpdateField(rate);
    image_parameters_.Update(kernels_, images_, rate, &field_);
    field_.progress = static_cast<float>(std::clamp(progress, 0.0, 1.0));
    const StepReport report = Report(sums);
    AdaptRays(report);
    ++step_;
    if (step_ >= static_cast<std::uint64_t>(options_.warmup_steps) &&
        (step_ - static_cast<std::uint64_t>(options_.warmup_steps)) %
                static_cast<std::uint64_t>(options_.occupancy_interval) ==
            0) {
      const bool full = step_ == static_cast<std::uint64_t>(options_.warmup_steps);
      worker_->UpdateOccupancy(step_, full);
    }
    return report;
  }

  RadianceField& field() {
    worker_->Download();
    return field_;
  }
  void SetCells(SceneCells cells) { field_.cells = std::move(cells); }
  void SetFrame(const FieldFrame& frame) { field_.frame = frame; }
  std::size_t DeviceBytes() const { return worker_->DeviceBytes(); }

 private:
  std::unique_ptr<StepWorker> MakeWorker(const DeviceChoice& device) {
    if (!device.IsCpu()) {
      return std::make_unique<DeviceWorker>(
          device, options_, views_, image_parameters_, occupancy_, &field_);
    }
    return std::make_unique<CpuWorker>(options_, views_, image_parameters_, &occupancy_, &field_);
  }

  StepReport Report(const StepSums& sums) const {
    StepReport report;
    for (const ImageGradient& images : images_) {
      report.rays += images.targets.size();
    }
    report.samples = sums.samples;
    report.weighted = sums.weighted;
    const double mean =
        sums.squared_error / static_cast<double>(std::max<std::size_t>(1, sums.color_values));
    report.psnr_db = -10 * std::log10(std::max(1e-12, mean));
    return report;
  }

  // As many rays as make up the wanted number of samples, by what this step's took.
  void AdaptRays(const StepReport& report) {
    const double per_ray =
        std::max(1.0, static_cast<double>(report.samples) / static_cast<double>(report.rays));
    const int samples = step_ < static_cast<std::uint64_t>(options_.warmup_steps)
                            ? options_.target_samples / 4
                            : options_.target_samples;
    const double wanted = static_cast<double>(samples) / per_ray;
    const double next =
        std::clamp(wanted, 0.5 * static_cast<double>(rays_), 1.25 * static_cast<double>(rays_));
    // Coarse steps while space is fog and rays go far through it; by little at a time, as this
    // changes what the densities mean.
    step_factor_ = static_cast<float>(std::clamp(
        static_cast<double>(step_factor_) * std::clamp(per_ray / kWantedSamples, 0.97, 1.03),
        1.0,
        kMaxStepFactor));
    // A field is rendered with the steps that it was trained with.
    field_.march.min_step = step_factor_ * options_.march.min_step;
    field_.march.max_step = step_factor_ * options_.march.max_step;
    field_.march.cone_angle = step_factor_ * options_.march.cone_angle;
    rays_ = std::clamp<std::size_t>(
        static_cast<std::size_t>(next),
        std::min<std::size_t>(512, static_cast<std::size_t>(options_.max_rays)),
        static_cast<std::size_t>(options_.max_rays));
  }

  TrainOptions options_;
  std::vector<TrainingView> views_;
  const Kernels& kernels_;
  RadianceField field_;
  internal::OccupancyUpdate occupancy_;
  internal::ImageParameters image_parameters_;
  std::vector<ImageGradient> images_;
  std::unique_ptr<StepWorker> worker_;
  std::size_t rays_ = 512;
  float step_factor_ = static_cast<float>(kMaxStepFactor);
  std::uint64_t step_ = 0;
};

Trainer::Trainer(const TrainOptions& options,
                 std::vector<TrainingView> views,
                 const SceneBox& box,
                 const DeviceChoice& device) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  CheckViews(views);
  RadianceField field(
      options.field, options.march, box, views.front().image.channels(), options.seed);
  impl_ = std::make_unique<Impl>(options, std::move(views), std::move(field), device);
}

Trainer::Trainer(const TrainOptions& options,
                 std::vector<TrainingView> views,
                 RadianceField field,
                 const DeviceChoice& device) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  CheckViews(views);
  if (views.front().image.channels() != field.channels) {
    ThrowInputError("training: the images have {} channels, the model to go on with has {}",
                    views.front().image.channels(),
                    field.channels);
  }
  TrainOptions own = options;
  own.field = field.options;
  impl_ = std::make_unique<Impl>(own, std::move(views), std::move(field), device);
}

Trainer::~Trainer() = default;
Trainer::Trainer(Trainer&&) noexcept = default;
Trainer& Trainer::operator=(Trainer&&) noexcept = default;

StepReport Trainer::Step(double progress) {
  return impl_->Step(progress);
}

void Trainer::SetCells(SceneCells cells) {
  impl_->SetCells(std::move(cells));
}

void Trainer::SetFrame(const FieldFrame& frame) {
  impl_->SetFrame(frame);
}

const RadianceField& Trainer::field() const {
  return impl_->field();
}

std::size_t Trainer::device_bytes() const {
  return impl_->DeviceBytes();
}

RadianceField Trainer::TakeField() && {
  return std::move(impl_->field());
}

}  // namespace deja_view::nerf
