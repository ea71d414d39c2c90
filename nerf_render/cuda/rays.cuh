#pragma once

#include "deja_view/base/host_device.hpp"
#include "deja_view/base/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "device_engine.hpp"
#include "textured_square.hpp"

// Where rays come from: pixels of a view to render, or random ones of the training images.

namespace deja_view::nerf::internal {

/// exp(k0 s + k1 s^2 + k2 s^3): Vignetting::At.
DEJA_VIEW_HOST_DEVICE inline float VignettingAt(const std::array<float, 3>& k, float s) {
  return std::exp(s * (k[0] + s * (k[1] + s * k[2])));
}

DEJA_VIEW_HOST_DEVICE inline std::array<double, 3> Rotate(const PlainPose& pose,
                                                          const std::array<double, 3>& v) {
  std::array<double, 3> result{};
  for (std::size_t i = 0; i < 3; ++i) {
    result[i] = pose.R[3 * i] * v[0] + pose.R[3 * i + 1] * v[1] + pose.R[3 * i + 2] * v[2];
  }
  return result;
}

/// Index: pixel, from `first` on.
struct RayOfPixel {
  RenderJob job;
  BoxView box;
  std::size_t first = 0;
  Ray* rays = nullptr;
  float* vignetting = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const auto width = static_cast<std::size_t>(job.width);
    const std::size_t pixel = first + index;
    const std::size_t row = pixel / width;
    const std::array<double, 3> d_C =
        job.lens.Unproject(static_cast<double>(pixel % width), static_cast<double>(row));
    const std::array<double, 3> d_N = Rotate(job.T_N_C, d_C);
    rays[index] = RayInBox(box, job.T_N_C.t.data(), d_N.data(), 0.5F);
    const float off_axis = 1 - static_cast<float>(d_C[2]);
    vignetting[index] = job.vignetting ? VignettingAt(job.vignetting_k, off_axis) : 1.0F;
  }
};

/// An image on a device.
struct ImageView {
  const std::uint8_t* pixels = nullptr;
  int width = 0;
  int height = 0;
  std::uint32_t lens = 0;
};

/// Which pixel a training ray goes through.
struct DrawnPixel {
  std::uint32_t view = 0;
  int x = 0;
  int y = 0;
  float range = 0;  ///< in unit lengths; 0: not a depth point's
  float jitter = 0;
};

/// Index: ray of a step, from `first` on. Draws what RayBatch draws, a ray at a time: each knows
/// how many random numbers those before it take.
struct DrawRay {
  const LensView* lenses = nullptr;
  const ImageView* images = nullptr;
  std::size_t image_count = 0;
  const PlainPoint* points = nullptr;
  std::size_t point_count = 0;
  const PlainPose* poses = nullptr;
  const float* latents = nullptr;
  std::size_t latent_size = 0;
  std::array<float, 3> vignetting_k{};
  std::size_t channels = 1;
  BoxView box;
  std::uint64_t seed = 0;
  std::uint64_t step = 0;
  std::size_t depth_rays = 0;  ///< of every chunk
  SquareOptions squares;
  std::size_t first = 0;
  Ray* rays = nullptr;
  RayTarget* targets = nullptr;

  DEJA_VIEW_HOST_DEVICE DrawnPixel Draw(std::size_t ray) const {
    const std::size_t i = ray % kRaysPerChunk;
    Random random(seed, step * 65536 + ray / kRaysPerChunk);
    DrawnPixel pixel;
    if (i < depth_rays) {
      random.Skip(2 * i);
      const PlainPoint& point = points[random.Index(static_cast<std::uint32_t>(point_count))];
      pixel = {point.view, point.x, point.y, point.range, random.UniformFloat()};
      return pixel;
    }
    const auto side = static_cast<std::size_t>(squares.side);
    const std::size_t rays_per_square = side * side;
    const std::size_t number = (i - depth_rays) / rays_per_square;
    const std::size_t place = (i - depth_rays) % rays_per_square;
    random.Skip(2 * depth_rays + number * (1 + NumbersPerSquare(squares) + rays_per_square));
    pixel.view = random.Index(static_cast<std::uint32_t>(image_count));
    const ImageView& image = images[pixel.view];
    const PixelRows pixels{image.pixels,
                           image.width,
                           image.height,
                           channels,
                           static_cast<std::size_t>(image.width) * channels};
    const SquareCorner at = DrawSquare(pixels, squares, &random);
    pixel.x = at.x + static_cast<int>(place) % squares.side;
    pixel.y = at.y + static_cast<int>(place) / squares.side;
    random.Skip(place);
    pixel.jitter = random.UniformFloat();
    return pixel;
  }

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const DrawnPixel pixel = Draw(first + index);
    const ImageView& image = images[pixel.view];
    std::array<double, 3> d_C = lenses[image.lens].Unproject(pixel.x, pixel.y);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      d_C[axis] = static_cast<double>(static_cast<float>(d_C[axis]));  // as RayBatch keeps them
    }
    const PlainPose& pose = poses[pixel.view];
    const std::array<double, 3> d_N = Rotate(pose, d_C);
    rays[index] = RayInBox(box, pose.t.data(), d_N.data(), pixel.jitter);
    rays[index].latent = latent_size > 0 ? latents + pixel.view * latent_size : nullptr;
    RayTarget target;
    target.view = pixel.view;
    target.range = pixel.range;
    target.off_axis = 1 - static_cast<float>(d_C[2]);
    target.vignetting = VignettingAt(vignetting_k, target.off_axis);
    target.backdrop = BackdropOf(pixel.jitter);
    const std::size_t at =
        (static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(image.width) +
         static_cast<std::size_t>(pixel.x)) *
        channels;
    for (std::size_t c = 0; c < channels; ++c) {
      target.color[c] = static_cast<float>(image.pixels[at + c]) / 255;
    }
    targets[index] = target;
  }
};

}  // namespace deja_view::nerf::internal
