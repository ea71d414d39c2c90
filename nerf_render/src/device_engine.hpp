#pragma once

#include "deja_view/nerf/device.hpp"
#include "deja_view/nerf/kernel_table.hpp"
#include "deja_view/nerf/occupancy_view.hpp"
#include "deja_view/nerf/options.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lens_view.hpp"
#include "loss_of_ray.hpp"
#include "ray_march.hpp"
#include "step_plan.hpp"

namespace deja_view::nerf::internal {

/// A field's sizes in plain numbers; of no levels and layers where a part is missing.
struct FieldLayout {
  struct Grid {
    std::vector<GridLevel> levels;
    std::size_t values = 0;
  };
  Grid geometry, appearance, background;
  std::vector<LayerShape> density, color, background_color;  ///< weights, then biases, of each
  int channels = 1;
  int direction_degree = 0;
  int latent_size = 0;
  OccupancyView occupancy;  ///< its words and leaps in the host's memory
  BoxView box;
};

/// A field's numbers in the host's memory, as many of each as the layout says.
template <typename Float, typename Word>
struct FieldArrays {
  Float* geometry = nullptr;
  Float* appearance = nullptr;
  Float* background = nullptr;
  Float* density = nullptr;
  Float* color = nullptr;
  Float* background_color = nullptr;
  Word* occupancy_words = nullptr;
};

/// Rotation (row by row) and translation [m] of a camera in N.
struct PlainPose {
  std::array<double, 9> R{};
  std::array<double, 3> t{};
};

/// A view to render.
struct RenderJob {
  LensView lens;
  int width = 0;
  PlainPose T_N_C;
  TraceOptions trace;
  float gain = 1;
  float bias = 0;
  bool vignetting = true;
  std::array<float, 3> vignetting_k{};
};

/// Pixels in the host's memory, channel by channel where there are several.
struct PixelArrays {
  std::uint8_t* image = nullptr;
  float* depth = nullptr;
  float* depth_variance = nullptr;
  float* opacity = nullptr;
};

/// An image to train on, and a point of one.
struct PlainImage {
  const std::uint8_t* pixels = nullptr;  ///< row by row without gaps
  int width = 0;
  int height = 0;
  int channels = 1;
  std::uint32_t lens = 0;

  std::size_t bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
           static_cast<std::size_t>(channels);
  }
};
struct PlainPoint {
  std::uint32_t view = 0;
  int x = 0;  ///< [px]
  int y = 0;
  float range = 0;  ///< in unit lengths
};
struct TrainingSet {
  std::vector<LensView> lenses;
  std::vector<PlainImage> images;
  std::vector<PlainPoint> points;
};

/// What belongs to the images, as it is before a step.
struct ImageState {
  std::vector<GainBias> gain_bias;
  std::vector<float> latents;  ///< views x latent_size
  std::vector<PlainPose> poses;
  std::array<float, 3> vignetting_k{};
};

/// What rays leave for the parameters of their images.
struct RayGradients {
  std::vector<RayTarget> targets;
  std::vector<GainBias> d_exposure;
  std::vector<float> d_latent;  ///< rays x latent_size
};

/// A card with one field in its memory. All calls throw DeviceError; after a DeviceMemoryError the
/// field is as it was, gradients need DropGradients, and less at a time may fit.
class DeviceEngine {
 public:
  virtual ~DeviceEngine() = default;

  virtual std::string Name() const = 0;
  virtual std::size_t PeakBytes() const = 0;  ///< of the card's memory that it has held

  using ConstArrays = FieldArrays<const float, const std::uint64_t>;
  using Arrays = FieldArrays<float, std::uint64_t>;
  virtual void LoadField(const FieldLayout& layout, const ConstArrays& values) = 0;
  virtual void SaveField(const Arrays& values) = 0;

  /// Pixels [first, first + count) of the view, row by row.
  virtual void Render(const RenderJob& job,
                      std::size_t first,
                      std::size_t count,
                      const PixelArrays& out) = 0;

  /// `open` are the cells that may hold matter, as OccupancyView::words.
  virtual void StartTraining(const TrainOptions& options,
                             const TrainingSet& set,
                             const std::vector<std::uint64_t>& open) = 0;
  virtual void SetImages(const ImageState& state) = 0;
  /// Adds the gradients of rays [first, first + count) of the plan.
  virtual StepSums AddRays(const StepPlan& plan,
                           std::size_t first,
                           std::size_t count,
                           RayGradients* out) = 0;
  virtual void DropGradients() = 0;
  /// Adam with the gathered gradients, at `rate` times the options' learning rates.
  virtual void UpdateField(float rate) = 0;
  virtual void UpdateOccupancy(std::uint64_t round, bool full) = 0;
};

}  // namespace deja_view::nerf::internal
