#pragma once

#include "deja_view/nerf/kernels.hpp"

#include <memory>
#include <mutex>
#include <vector>

#include "backward.hpp"
#include "grid_optimizer.hpp"
#include "occupancy_update.hpp"
#include "ray_batch.hpp"
#include "step_worker.hpp"

namespace deja_view::nerf::internal {

/// Trains on the CPU. Chunks of rays leave their gradients, which are summed in order: the same
/// bits on any number of threads.
class CpuWorker final : public StepWorker {
 public:
  /// Everything given must live on.
  CpuWorker(const TrainOptions& options,
            const std::vector<TrainingView>& views,
            const ImageParameters& image_parameters,
            OccupancyUpdate* occupancy,
            RadianceField* field);

  StepSums RunRays(const StepPlan& plan, std::vector<ImageGradient>* images) override;
  void UpdateField(float rate) override;
  void UpdateOccupancy(std::uint64_t round, bool full) override;
  void Download() override {}

 private:
  /// What a thread works with.
  struct Tools {
    Tools(const RadianceField& field, const Kernels& kernels) : tracer(field, kernels) {}
    RayTracer tracer;
    Trace trace;
    LossGradient loss;
    BackwardScratch scratch;
    std::vector<Ray> rays;
  };

  std::unique_ptr<Tools> TakeTools();
  StepSums RunChunk(const StepPlan& plan, std::size_t chunk, Tools* tools, ImageGradient* images);
  void UpdateGrids(float rate);
  void UpdateNetwork(std::vector<float> ChunkGradient::*part,
                     const AdamStep& step,
                     DenseAdam* adam,
                     Network* network);

  const TrainOptions& options_;
  const ImageParameters& image_parameters_;
  OccupancyUpdate& occupancy_;
  RadianceField& field_;
  const Kernels& kernels_;
  RayBatch batch_;
  GridOptimizer geometry_;
  GridOptimizer appearance_;
  GridOptimizer background_;
  DenseAdam density_;
  DenseAdam color_;
  DenseAdam background_color_;
  std::vector<ChunkGradient> gradients_;
  std::vector<StepSums> sums_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Tools>> tools_;  ///< idle; they keep their memory
};

}  // namespace deja_view::nerf::internal
