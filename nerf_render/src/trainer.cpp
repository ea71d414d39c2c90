#include "deja_view/nerf/trainer.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/nerf/kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "backward.hpp"
#include "grid_optimizer.hpp"
#include "image_parameters.hpp"
#include "occupancy_update.hpp"
#include "ray_batch.hpp"
#include "training_views.hpp"

namespace deja_view::nerf {
namespace {

using internal::CheckViews;
using internal::ChunkGradient;
using internal::DenseAdam;
using internal::ImageGradient;
using internal::RayBatch;

constexpr double kWantedSamples = 28;  ///< per ray, at most, where coarser steps can bring it about
constexpr double kMaxStepFactor = 8;

/// What a thread works with.
struct Worker {
  Worker(const RadianceField& field, const Kernels& kernels) : tracer(field, kernels) {}
  internal::RayTracer tracer;
  internal::Trace trace;
  internal::LossGradient loss;
  internal::BackwardScratch scratch;
  std::vector<internal::Ray> rays;
};

/// What a chunk leaves for the sums over all chunks, which are made in order.
struct ChunkResult {
  std::size_t samples = 0;
  double squared_error = 0;
  std::size_t color_values = 0;
};

}  // namespace

class Trainer::Impl {
 public:
  Impl(const TrainOptions& options, std::vector<TrainingView> views, RadianceField field)
      : options_(options),
        views_(std::move(views)),
        kernels_(FindKernels(options.kernels)),
        field_(std::move(field)),
        batch_(options_, views_),
        occupancy_(views_, options.threads, options.carve_votes, &field_),
        geometry_(field_.geometry),
        appearance_(field_.appearance),
        density_(field_.density.parameters().size()),
        color_(field_.color.parameters().size()),
        background_(field_.background),
        background_color_(field_.background_color.parameters().size()),
        image_parameters_(options_, views_, &field_) {
    if (field_.progress > 0) {
      // What was learnt tells where matter is; there is nothing to warm up.
      step_ = static_cast<std::uint64_t>(options_.warmup_steps);
      step_factor_ = std::max(1.0F, field_.march.min_step / options_.march.min_step);
      occupancy_.Run(kernels_, options_, step_, true, &field_);
    }
  }

  StepReport Step(double progress) {
    const std::size_t chunks = std::max<std::size_t>(1, rays_ / RayBatch::kChunk);
    gradients_.resize(chunks);
    results_.resize(chunks);
    images_.resize(chunks);
    const internal::TraceOptions trace_options{options_.march, step_factor_};
    const float depth_share =
        options_.depth_share + static_cast<float>(std::clamp(progress, 0.0, 1.0)) *
                                   (options_.final_depth_share - options_.depth_share);
    ParallelFor(
        options_.threads,
        chunks,
        [&](std::size_t begin, std::size_t end) {
          std::unique_ptr<Worker> worker = TakeWorker();
          for (std::size_t c = begin; c < end; ++c) {
            RunChunk(c, trace_options, depth_share, worker.get());
          }
          const std::lock_guard<std::mutex> lock(mutex_);
          workers_.push_back(std::move(worker));
        },
        4);
    const double decay =
        std::clamp((progress - static_cast<double>(options_.decay_start)) /
                       std::max(1e-6, 1 - static_cast<double>(options_.decay_start)),
                   0.0,
                   1.0);
    const auto rate =
        static_cast<float>(std::pow(static_cast<double>(options_.final_learning_rate), decay));
    UpdateGrids(rate);
    UpdateNetworks(rate);
    image_parameters_.Update(kernels_, images_, rate, progress, &field_);
    field_.progress = static_cast<float>(std::clamp(progress, 0.0, 1.0));
    const StepReport report = Report();
    AdaptRays(report);
    ++step_;
    if (step_ >= static_cast<std::uint64_t>(options_.warmup_steps) &&
        (step_ - static_cast<std::uint64_t>(options_.warmup_steps)) %
                static_cast<std::uint64_t>(options_.occupancy_interval) ==
            0) {
      const bool full = step_ == static_cast<std::uint64_t>(options_.warmup_steps);
      occupancy_.Run(kernels_, options_, step_, full, &field_);
    }
    return report;
  }

  RadianceField& field() { return field_; }
  std::vector<Rigid3> Poses() const {
    std::vector<Rigid3> poses;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      poses.push_back(image_parameters_.T_N_C(v));
    }
    return poses;
  }

 private:
  std::unique_ptr<Worker> TakeWorker() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (workers_.empty()) {
      return std::make_unique<Worker>(field_, kernels_);
    }
    std::unique_ptr<Worker> worker = std::move(workers_.back());
    workers_.pop_back();
    return worker;
  }

  void RunChunk(std::size_t c,
                const internal::TraceOptions& trace_options,
                float depth_share,
                Worker* worker) {
    ChunkResult& result = results_[c];
    ImageGradient& images = images_[c];
    batch_.Draw(field_, image_parameters_, step_, c, depth_share, &worker->rays, &images.targets);
    worker->tracer.Run(worker->rays, trace_options, &worker->trace);
    const internal::LossOptions loss_options{
        options_.huber_delta, options_.depth_weight, options_.distortion_weight};
    internal::ComputeLoss(field_,
                          worker->trace,
                          images.targets,
                          image_parameters_.gain_bias(),
                          loss_options,
                          &worker->loss);
    internal::Backpropagate(
        field_, kernels_, worker->loss, &worker->trace, &worker->scratch, &gradients_[c]);
    images.d_exposure = worker->loss.d_exposure;
    images.d_latent = gradients_[c].latent;
    if (options_.refine_poses) {
      internal::ComputePoseGradients(
          field_, worker->rays, worker->trace, gradients_[c], &images.d_pose);
    }
    result.samples = worker->trace.evaluated;
    result.squared_error = worker->loss.squared_error;
    result.color_values = worker->loss.color_values;
  }

  AdamStep MakeStep(float learning_rate) const {
    AdamStep step;
    step.learning_rate = learning_rate;
    return step;
  }

  void UpdateGrids(float rate) {
    const AdamStep step = MakeStep(rate * options_.grid_learning_rate);
    struct Job {
      internal::GridOptimizer* optimizer;
      internal::GridGradient ChunkGradient::*part;
      FeatureGrid* grid;
      std::size_t level;
    };
    std::vector<Job> jobs;
    const auto add = [&](internal::GridOptimizer* optimizer,
                         internal::GridGradient ChunkGradient::*part,
                         FeatureGrid* grid) {
      for (std::size_t level = optimizer->levels(); level-- > 0;) {
        jobs.push_back({optimizer, part, grid, level});
      }
    };
    // The fine levels first: they take longest.
    add(&appearance_, &ChunkGradient::appearance, &field_.appearance);
    add(&geometry_, &ChunkGradient::geometry, &field_.geometry);
    add(&background_, &ChunkGradient::background, &field_.background);
    ParallelFor(options_.threads, jobs.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Job& job = jobs[i];
        job.optimizer->Update(job.level, gradients_, job.part, step, kernels_, job.grid);
      }
    });
  }

  void UpdateNetwork(std::vector<float> ChunkGradient::*part,
                     const AdamStep& step,
                     DenseAdam* adam,
                     Network* network) {
    for (const ChunkGradient& chunk : gradients_) {
      for (std::size_t i = 0; i < adam->gradient.size(); ++i) {
        adam->gradient[i] += (chunk.*part)[i];
      }
    }
    kernels_.adam(step,
                  adam->gradient.size(),
                  network->parameters().data(),
                  adam->gradient.data(),
                  adam->first.data(),
                  adam->second.data());
    network->UpdateTranspose();
  }

  void UpdateNetworks(float rate) {
    const AdamStep step = MakeStep(rate * options_.network_learning_rate);
    UpdateNetwork(&ChunkGradient::density_network, step, &density_, &field_.density);
    UpdateNetwork(&ChunkGradient::color_network, step, &color_, &field_.color);
    if (options_.field.far_background) {
      UpdateNetwork(
          &ChunkGradient::background_network, step, &background_color_, &field_.background_color);
    }
  }

  StepReport Report() const {
    StepReport report;
    double squared_error = 0;
    std::size_t values = 0;
    for (std::size_t c = 0; c < results_.size(); ++c) {
      report.rays += images_[c].targets.size();
      report.samples += results_[c].samples;
      report.weighted += gradients_[c].geometry.size();
      squared_error += results_[c].squared_error;
      values += results_[c].color_values;
    }
    const double mean = squared_error / static_cast<double>(std::max<std::size_t>(1, values));
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
  RayBatch batch_;
  internal::OccupancyUpdate occupancy_;
  internal::GridOptimizer geometry_;
  internal::GridOptimizer appearance_;
  DenseAdam density_;
  DenseAdam color_;
  internal::GridOptimizer background_;
  DenseAdam background_color_;
  internal::ImageParameters image_parameters_;
  std::vector<ChunkGradient> gradients_;
  std::vector<ChunkResult> results_;
  std::vector<ImageGradient> images_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Worker>> workers_;  ///< idle; they keep their memory
  std::size_t rays_ = 512;
  float step_factor_ = static_cast<float>(kMaxStepFactor);
  std::uint64_t step_ = 0;
};

Trainer::Trainer(const TrainOptions& options,
                 std::vector<TrainingView> views,
                 const SceneBox& box) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  CheckViews(views);
  RadianceField field(
      options.field, options.march, box, views.front().image.channels(), options.seed);
  impl_ = std::make_unique<Impl>(options, std::move(views), std::move(field));
}

Trainer::Trainer(const TrainOptions& options,
                 std::vector<TrainingView> views,
                 RadianceField field) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  CheckViews(views);
  if (views.front().image.channels() != field.channels) {
    ThrowInputError("training: the images have {} channels, the model to go on with has {}",
                    views.front().image.channels(),
                    field.channels);
  }
  TrainOptions own = options;
  own.field = field.options;
  impl_ = std::make_unique<Impl>(own, std::move(views), std::move(field));
}

Trainer::~Trainer() = default;
Trainer::Trainer(Trainer&&) noexcept = default;
Trainer& Trainer::operator=(Trainer&&) noexcept = default;

StepReport Trainer::Step(double progress) {
  return impl_->Step(progress);
}

void Trainer::SetCells(SceneCells cells) {
  impl_->field().cells = std::move(cells);
}

void Trainer::SetFrame(const FieldFrame& frame) {
  impl_->field().frame = frame;
}

const RadianceField& Trainer::field() const {
  return impl_->field();
}

std::vector<Rigid3> Trainer::poses() const {
  return impl_->Poses();
}

RadianceField Trainer::TakeField() && {
  return std::move(impl_->field());
}

}  // namespace deja_view::nerf
