#pragma once

#include <algorithm>
#include <vector>

#include "device_memory.cuh"
#include "launch.cuh"
#include "rays.cuh"

namespace deja_view::nerf::internal {

/// The images to train on, on a device.
template <typename System>
class DeviceImages {
 public:
  DeviceImages(const TrainingSet& set, const TrainOptions& options)
      : options_(options), squares_{options.patch_px, options.textured_share, options.textured_of} {
    lenses_.Upload(set.lenses);
    points_.Upload(set.points);
    std::size_t bytes = 0;
    for (const PlainImage& image : set.images) {
      bytes += image.bytes();
      squares_.side = std::min({squares_.side, image.width, image.height});
    }
    pixels_.Resize(bytes);
    std::vector<ImageView> views;
    std::size_t offset = 0;
    for (const PlainImage& image : set.images) {
      System::Upload(image.pixels, image.bytes(), pixels_.data() + offset);
      views.push_back({pixels_.data() + offset, image.width, image.height, image.lens});
      offset += image.bytes();
    }
    images_.Upload(views);
  }

  void Set(const ImageState& state) {
    gain_bias_.Upload(state.gain_bias);
    latents_.Upload(state.latents);
    poses_.Upload(state.poses);
    vignetting_k_ = state.vignetting_k;
  }
  const GainBias* gain_bias() const { return gain_bias_.data(); }

  /// Rays [first, first + count) of a step; RayBatch::Draw.
  void Draw(const StepPlan& plan,
            std::size_t first,
            std::size_t count,
            const FieldLayout& layout,
            DeviceArray<System, Ray>* rays,
            DeviceArray<System, RayTarget>* targets) const {
    rays->Resize(count);
    targets->Resize(count);
    DrawRay draw;
    draw.lenses = lenses_.data();
    draw.images = images_.data();
    draw.image_count = images_.size();
    draw.points = points_.data();
    draw.point_count = points_.size();
    draw.poses = poses_.data();
    draw.latents = latents_.data();
    draw.latent_size = static_cast<std::size_t>(layout.latent_size);
    draw.vignetting_k = vignetting_k_;
    draw.channels = static_cast<std::size_t>(layout.channels);
    draw.box = layout.box;
    draw.seed = options_.seed;
    draw.step = plan.step;
    draw.depth_rays =
        points_.size() == 0 || options_.depth_weight == 0
            ? std::size_t{0}
            : static_cast<std::size_t>(plan.depth_share * static_cast<float>(kRaysPerChunk));
    draw.squares = squares_;
    draw.first = first;
    draw.rays = rays->data();
    draw.targets = targets->data();
    ForEach<System>(count, draw);
  }

 private:
  TrainOptions options_;
  SquareOptions squares_;
  DeviceArray<System, LensView> lenses_;
  DeviceArray<System, std::uint8_t> pixels_;
  DeviceArray<System, ImageView> images_;
  DeviceArray<System, PlainPoint> points_;
  DeviceArray<System, GainBias> gain_bias_;
  DeviceArray<System, float> latents_;
  DeviceArray<System, PlainPose> poses_;
  std::array<float, 3> vignetting_k_{};
};

}  // namespace deja_view::nerf::internal
