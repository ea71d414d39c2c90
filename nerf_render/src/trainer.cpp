#include "deja_view/nerf/trainer.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "backward.hpp"
#include "grid_optimizer.hpp"
#include "occupancy_update.hpp"
#include "ray_batch.hpp"

namespace deja_view::nerf {
namespace {

using internal::ChunkGradient;
using internal::GainBias;
using internal::RayBatch;

constexpr double kWantedSamples = 28;  ///< per ray, at most, where coarser steps can bring it about
constexpr double kMaxStepFactor = 8;

void CheckViews(const std::vector<TrainingView>& views) {
  if (views.empty()) {
    ThrowInputError("training: expected at least one posed image, found none");
  }
  for (const TrainingView& view : views) {
    if (view.image.type() != CV_8UC1 && view.image.type() != CV_8UC3) {
      ThrowInputError("{}: expected an 8-bit image of one or three channels", view.name);
    }
    if (view.image.cols != view.camera->width() || view.image.rows != view.camera->height()) {
      ThrowInputError("{}: the image is {}x{}, its camera {}x{}",
                      view.name,
                      view.image.cols,
                      view.image.rows,
                      view.camera->width(),
                      view.camera->height());
    }
    if (view.image.channels() != views.front().image.channels()) {
      ThrowInputError("{}: has {} channels, {} has {}",
                      view.name,
                      view.image.channels(),
                      views.front().name,
                      views.front().image.channels());
    }
    if (!view.T_N_C.IsFinite() || std::abs(view.T_N_C.q.norm() - 1) > 1e-6) {
      ThrowInputError("{}: its pose is not a rigid transform", view.name);
    }
  }
}

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
  std::vector<internal::RayTarget> targets;
  std::vector<GainBias> d_exposure;
  std::size_t samples = 0;
  double squared_error = 0;
  std::size_t color_values = 0;
};

struct DenseAdam {
  explicit DenseAdam(std::size_t size) : gradient(size), first(size), second(size) {}
  std::vector<float> gradient, first, second;
};

}  // namespace

SceneBox BoxAround(const std::vector<TrainingView>& views, double margin) {
  SceneBox box;
  box.min.setConstant(std::numeric_limits<double>::max());
  box.max.setConstant(std::numeric_limits<double>::lowest());
  const auto add = [&](const Eigen::Vector3d& p_N) {
    box.min = box.min.cwiseMin(p_N);
    box.max = box.max.cwiseMax(p_N);
  };
  for (const TrainingView& view : views) {
    add(view.T_N_C.t);
    for (const DepthPoint& point : view.points) {
      add(view.T_N_C *
          (static_cast<double>(point.range) * view.camera->Unproject({point.u, point.v})));
    }
  }
  const double diagonal = views.empty() ? 0 : (box.max - box.min).norm();
  if (!(diagonal > 1e-6) || !std::isfinite(diagonal)) {
    ThrowInputError("training: the {} camera poses are all in one place", views.size());
  }
  const Eigen::Vector3d grow = Eigen::Vector3d::Constant(margin * diagonal);
  box.min -= grow;
  box.max += grow;
  return box;
}

class Trainer::Impl {
 public:
  Impl(const TrainOptions& options, std::vector<TrainingView> views, const SceneBox& box)
      : options_(options),
        views_(std::move(views)),
        kernels_(FindKernels(options.kernels)),
        field_(options.field, options.march, box, views_.front().image.channels(), options.seed),
        batch_(options_, views_),
        occupancy_(views_, options.threads, &field_),
        geometry_(field_.geometry),
        appearance_(field_.appearance),
        density_(field_.density.parameters().size()),
        color_(field_.color.parameters().size()),
        exposure_(32 * ((views_.size() + 15) / 16)),
        log_exposure_(exposure_.first.size(), 0.0F),
        gain_bias_(views_.size()) {
    for (const TrainingView& view : views_) {
      field_.exposures.push_back({view.name, view.stamp_ns, 1.0F, 0.0F});
    }
  }

  StepReport Step(double progress) {
    const std::size_t chunks = std::max<std::size_t>(1, rays_ / RayBatch::kChunk);
    gradients_.resize(chunks);
    results_.resize(chunks);
    const internal::TraceOptions trace_options{options_.march, step_factor_};
    ParallelFor(
        options_.threads,
        chunks,
        [&](std::size_t begin, std::size_t end) {
          std::unique_ptr<Worker> worker = TakeWorker();
          for (std::size_t c = begin; c < end; ++c) {
            RunChunk(c, trace_options, worker.get());
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
    if (options_.exposure) {
      UpdateExposures(rate);
    }
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

  void RunChunk(std::size_t c, const internal::TraceOptions& trace_options, Worker* worker) {
    ChunkResult& result = results_[c];
    batch_.Draw(field_, step_, c, &worker->rays, &result.targets);
    worker->tracer.Run(worker->rays, trace_options, &worker->trace);
    const internal::LossOptions loss_options{
        options_.huber_delta, options_.depth_weight, options_.distortion_weight};
    internal::ComputeLoss(
        field_, worker->trace, result.targets, gain_bias_, loss_options, &worker->loss);
    internal::Backpropagate(
        field_, kernels_, worker->loss, &worker->trace, &worker->scratch, &gradients_[c]);
    result.d_exposure = worker->loss.d_exposure;
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
    const std::size_t fine = appearance_.levels();
    // The fine levels first: they take longest.
    ParallelFor(
        options_.threads, fine + geometry_.levels(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            if (i < fine) {
              appearance_.Update(fine - 1 - i,
                                 gradients_,
                                 &ChunkGradient::appearance_levels,
                                 step,
                                 kernels_,
                                 &field_.appearance);
            } else {
              geometry_.Update(geometry_.levels() - 1 - (i - fine),
                               gradients_,
                               &ChunkGradient::geometry_levels,
                               step,
                               kernels_,
                               &field_.geometry);
            }
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
  }

  // Parameters 2 i and 2 i + 1: logarithm of the gain, and bias, of view i. Their means are held at
  // 0, since radiance and gain could trade places.
  void UpdateExposures(float rate) {
    for (const ChunkResult& result : results_) {
      for (std::size_t r = 0; r < result.targets.size(); ++r) {
        const std::size_t v = result.targets[r].view;
        exposure_.gradient[2 * v] += result.d_exposure[r].gain * gain_bias_[v].gain;
        exposure_.gradient[2 * v + 1] += result.d_exposure[r].bias;
      }
    }
    kernels_.adam(MakeStep(rate * options_.exposure_learning_rate),
                  log_exposure_.size(),
                  log_exposure_.data(),
                  exposure_.gradient.data(),
                  exposure_.first.data(),
                  exposure_.second.data());
    double mean_gain = 0;
    double mean_bias = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      mean_gain += static_cast<double>(log_exposure_[2 * v]);
      mean_bias += static_cast<double>(log_exposure_[2 * v + 1]);
    }
    const auto count = static_cast<double>(views_.size());
    for (std::size_t v = 0; v < views_.size(); ++v) {
      log_exposure_[2 * v] -= static_cast<float>(mean_gain / count);
      log_exposure_[2 * v + 1] -= static_cast<float>(mean_bias / count);
      gain_bias_[v] = {std::exp(log_exposure_[2 * v]), log_exposure_[2 * v + 1]};
      field_.exposures[v].gain = gain_bias_[v].gain;
      field_.exposures[v].bias = gain_bias_[v].bias;
    }
  }

  StepReport Report() const {
    StepReport report;
    double squared_error = 0;
    std::size_t values = 0;
    for (std::size_t c = 0; c < results_.size(); ++c) {
      report.rays += results_[c].targets.size();
      report.samples += results_[c].samples;
      report.weighted += gradients_[c].size();
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
  DenseAdam exposure_;
  std::vector<float> log_exposure_;
  std::vector<GainBias> gain_bias_;
  std::vector<ChunkGradient> gradients_;
  std::vector<ChunkResult> results_;
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
  impl_ = std::make_unique<Impl>(options, std::move(views), box);
}

Trainer::~Trainer() = default;
Trainer::Trainer(Trainer&&) noexcept = default;
Trainer& Trainer::operator=(Trainer&&) noexcept = default;

StepReport Trainer::Step(double progress) {
  return impl_->Step(progress);
}

const RadianceField& Trainer::field() const {
  return impl_->field();
}

RadianceField Trainer::TakeField() && {
  return std::move(impl_->field());
}

}  // namespace deja_view::nerf
