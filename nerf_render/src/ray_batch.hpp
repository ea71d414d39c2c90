#pragma once

#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <map>

#include "image_parameters.hpp"
#include "ray_loss.hpp"
#include "step_plan.hpp"
#include "textured_square.hpp"

namespace deja_view::nerf::internal {

/// Draws training rays: squares of pixels of random images, of a share of them those with most
/// contrast of a few, and rays through depth points.
class RayBatch {
 public:
  RayBatch(const TrainOptions& options, const std::vector<TrainingView>& views);

  /// Chunk `chunk` of step `step`, `depth_share` of it through depth points where there are any;
  /// the same for the same numbers.
  void Draw(const RadianceField& field,
            const ImageParameters& images,
            std::uint64_t step,
            std::size_t chunk,
            float depth_share,
            std::vector<Ray>* rays,
            std::vector<RayTarget>* targets) const;

 private:
  struct Pixel {
    float x, y, z;
  };
  struct PointRef {
    std::uint32_t view;
    std::uint32_t point;
  };

  void AddRay(const RadianceField& field,
              const ImageParameters& images,
              std::uint32_t v,
              int x,
              int y,
              float jitter,
              std::vector<Ray>* rays,
              std::vector<RayTarget>* targets) const;

  const TrainOptions& options_;
  const std::vector<TrainingView>& views_;
  SquareOptions squares_;
  std::map<const Camera*, std::vector<Pixel>> directions_;  ///< unit rays in C, row by row
  std::vector<const std::vector<Pixel>*> directions_of_;    ///< per view
  std::vector<PointRef> points_;
};

}  // namespace deja_view::nerf::internal
