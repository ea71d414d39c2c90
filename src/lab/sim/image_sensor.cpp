#include "deja_view/lab/sim/image_sensor.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/sim/random.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

namespace deja_view::sim {
namespace {

constexpr int kToneSteps = 4096;
constexpr double kMaxLevel = 1.3;  // what is brighter stays white whatever the noise
constexpr std::size_t kNormals = std::size_t{1} << 16U;
constexpr std::uint64_t kNoiseStream = 20;
constexpr std::uint64_t kRowStream = 100000;

}  // namespace

ImageSensor::ImageSensor(const SensorOptions& options, const Camera& camera, std::uint64_t seed)
    : options_(options),
      seed_(seed),
      vignette_(camera.height(), camera.width(), CV_32FC1),
      tone_(kToneSteps + 1),
      noise_sigma_(kToneSteps + 1),
      normals_(kNormals) {
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      const Eigen::Vector3d ray = camera.Unproject({x, y});
      const double cosine = std::max(ray.z(), 0.2);
      const double tangent_squared = 1.0 / (cosine * cosine) - 1.0;
      vignette_.at<float>(y, x) =
          static_cast<float>(std::pow(1.0 + options.vignetting * tangent_squared, -1.5));
    }
  }
  for (int i = 0; i <= kToneSteps; ++i) {
    const double root = std::sqrt(kMaxLevel) * i / kToneSteps;
    tone_[static_cast<std::size_t>(i)] =
        static_cast<float>(255.0 * std::pow(root * root, 1.0 / options.gamma));
    noise_sigma_[static_cast<std::size_t>(i)] =
        static_cast<float>(options.noise * (1.0 + 1.2 * root));
  }
  Rng rng(seed, kNoiseStream);
  for (float& normal : normals_) {
    normal = static_cast<float>(rng.Normal());
  }
}

void ImageSensor::AdaptGain(const cv::Mat& radiance) {
  if (gain_ > 0 && !options_.auto_exposure) {
    return;
  }
  // Very bright windows count as moderately bright, so that they do not turn the rest black.
  double sum = 0;
  for (int y = 0; y < radiance.rows; ++y) {
    const float* row = radiance.ptr<float>(y);
    for (int x = 0; x < radiance.cols; ++x) {
      sum += std::min(row[x], 1.5F);
    }
  }
  const double mean = sum / static_cast<double>(radiance.total());
  const double wanted = options_.target_level / (mean + 1e-3);
  gain_ = gain_ > 0 ? gain_ + options_.exposure_adaption * (wanted - gain_) : wanted;
}

cv::Mat ImageSensor::Expose(const cv::Mat& radiance) {
  DEJA_VIEW_CHECK(radiance.type() == CV_32FC1 && radiance.size() == vignette_.size());
  AdaptGain(radiance);
  cv::Mat image(radiance.size(), CV_8UC1);
  const auto gain = static_cast<float>(gain_);
  const auto steps = static_cast<float>(kToneSteps / std::sqrt(kMaxLevel));
  for (int y = 0; y < image.rows; ++y) {
    const float* in = radiance.ptr<float>(y);
    const float* vignette = vignette_.ptr<float>(y);
    auto* out = image.ptr<std::uint8_t>(y);
    const std::size_t first =
        Rng(seed_ + frame_, kRowStream + static_cast<std::uint64_t>(y)).Next();
    for (int x = 0; x < image.cols; ++x) {
      const float level = std::min(gain * vignette[x] * in[x], static_cast<float>(kMaxLevel));
      const auto step = static_cast<std::size_t>(std::sqrt(level) * steps + 0.5F);
      const float normal = normals_[(first + static_cast<std::size_t>(x)) % kNormals];
      const float grey = tone_[step] + normal * noise_sigma_[step];
      out[x] = static_cast<std::uint8_t>(std::clamp(grey + 0.5F, 0.0F, 255.0F));
    }
  }
  ++frame_;
  return image;
}

}  // namespace deja_view::sim
