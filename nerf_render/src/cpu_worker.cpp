#include "cpu_worker.hpp"

#include "deja_view/base/parallel.hpp"

#include <utility>

namespace deja_view::nerf::internal {
namespace {

AdamStep AtRate(float learning_rate) {
  AdamStep step;
  step.learning_rate = learning_rate;
  return step;
}

}  // namespace

CpuWorker::CpuWorker(const TrainOptions& options,
                     const std::vector<TrainingView>& views,
                     const ImageParameters& image_parameters,
                     OccupancyUpdate* occupancy,
                     RadianceField* field)
    : options_(options),
      image_parameters_(image_parameters),
      occupancy_(*occupancy),
      field_(*field),
      kernels_(FindKernels(options.kernels)),
      batch_(options, views),
      geometry_(field->geometry),
      appearance_(field->appearance),
      background_(field->background),
      density_(field->density.parameters().size()),
      color_(field->color.parameters().size()),
      background_color_(field->background_color.parameters().size()) {}

StepSums CpuWorker::RunRays(const StepPlan& plan, std::vector<ImageGradient>* images) {
  gradients_.resize(plan.chunks);
  sums_.resize(plan.chunks);
  images->resize(plan.chunks);
  ParallelFor(
      options_.threads,
      plan.chunks,
      [&](std::size_t begin, std::size_t end) {
        std::unique_ptr<Tools> tools = TakeTools();
        for (std::size_t c = begin; c < end; ++c) {
          sums_[c] = RunChunk(plan, c, tools.get(), &(*images)[c]);
        }
        const std::lock_guard<std::mutex> lock(mutex_);
        tools_.push_back(std::move(tools));
      },
      4);
  StepSums total;
  for (const StepSums& sums : sums_) {
    total.Add(sums);
  }
  return total;
}

std::unique_ptr<CpuWorker::Tools> CpuWorker::TakeTools() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (tools_.empty()) {
    return std::make_unique<Tools>(field_, kernels_);
  }
  std::unique_ptr<Tools> tools = std::move(tools_.back());
  tools_.pop_back();
  return tools;
}

StepSums CpuWorker::RunChunk(const StepPlan& plan,
                             std::size_t c,
                             Tools* tools,
                             ImageGradient* images) {
  batch_.Draw(
      field_, image_parameters_, plan.step, c, plan.depth_share, &tools->rays, &images->targets);
  tools->tracer.Run(tools->rays, plan.trace, &tools->trace);
  const LossOptions loss_options{
      options_.huber_delta, options_.depth_weight, options_.distortion_weight, options_.opaque};
  ComputeLoss(field_,
              tools->trace,
              images->targets,
              image_parameters_.gain_bias(),
              loss_options,
              &tools->loss);
  Backpropagate(field_, kernels_, tools->loss, &tools->trace, &tools->scratch, &gradients_[c]);
  images->d_exposure = tools->loss.d_exposure;
  images->d_latent = gradients_[c].latent;
  return {tools->trace.evaluated,
          tools->trace.size(),
          tools->loss.squared_error,
          tools->loss.color_values};
}

void CpuWorker::UpdateField(float rate) {
  UpdateGrids(rate);
  const AdamStep step = AtRate(rate * options_.network_learning_rate);
  UpdateNetwork(&ChunkGradient::density_network, step, &density_, &field_.density);
  UpdateNetwork(&ChunkGradient::color_network, step, &color_, &field_.color);
  if (options_.field.far_background) {
    UpdateNetwork(
        &ChunkGradient::background_network, step, &background_color_, &field_.background_color);
  }
}

void CpuWorker::UpdateGrids(float rate) {
  const AdamStep step = GridStep(options_, rate);
  struct Job {
    GridOptimizer* optimizer;
    GridGradient ChunkGradient::*part;
    FeatureGrid* grid;
    std::size_t level;
  };
  std::vector<Job> jobs;
  const auto add =
      [&](GridOptimizer* optimizer, GridGradient ChunkGradient::*part, FeatureGrid* grid) {
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

void CpuWorker::UpdateNetwork(std::vector<float> ChunkGradient::*part,
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

void CpuWorker::UpdateOccupancy(std::uint64_t round, bool full) {
  occupancy_.Run(kernels_, options_, round, full, &field_);
}

}  // namespace deja_view::nerf::internal
