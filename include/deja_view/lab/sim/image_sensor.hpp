#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/lab/sim/options.hpp"

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view::sim {

/// Turns radiance into 8-bit images: vignetting, exposure that adapts from image to image, gamma,
/// noise.
class ImageSensor {
 public:
  ImageSensor(const SensorOptions& options, const Camera& camera, std::uint64_t seed);

  /// The next image (CV_8UC1) of `radiance` (CV_32FC1, the camera's size).
  cv::Mat Expose(const cv::Mat& radiance);

  /// Exposure of the last image: level = gain * radiance, 1 is white. 0 before the first image.
  double gain() const { return gain_; }

 private:
  void AdaptGain(const cv::Mat& radiance);

  SensorOptions options_;
  std::uint64_t seed_;
  std::uint64_t frame_ = 0;
  double gain_ = 0;
  cv::Mat vignette_;                ///< CV_32FC1, 1 on the axis
  std::vector<float> tone_;         ///< grey level over the square root of the level
  std::vector<float> noise_sigma_;  ///< [grey levels], over the same
  std::vector<float> normals_;      ///< standard normal numbers, to draw runs from
};

}  // namespace deja_view::sim
