#include "deja_view/sim/texture.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace deja_view::sim {
namespace {

constexpr float kTexelScale = 65535.0F;

/// 2^result = x for powers of two, linear in between: exact enough to pick a mip level, and the
/// same on every machine.
float FastLog2(float x) {
  int exponent = 0;
  const float mantissa = std::frexp(x, &exponent);
  return static_cast<float>(exponent - 2) + 2.0F * mantissa;
}

}  // namespace

Texture::Texture(const cv::Mat& reflectance) : size_(reflectance.cols) {
  DEJA_VIEW_CHECK(reflectance.type() == CV_32FC1);
  DEJA_VIEW_CHECK_OP(reflectance.rows, ==, reflectance.cols);
  DEJA_VIEW_CHECK(size_ > 0 && (size_ & (size_ - 1)) == 0);
  cv::Mat level = reflectance;
  while (true) {
    offsets_.push_back(texels_.size());
    for (int y = 0; y < level.rows; ++y) {
      for (int x = 0; x < level.cols; ++x) {
        const float value = std::clamp(level.at<float>(y, x), 0.0F, 1.0F);
        texels_.push_back(static_cast<std::uint16_t>(std::lround(value * kTexelScale)));
      }
    }
    ++levels_;
    if (level.cols == 1) {
      break;
    }
    cv::Mat half;
    cv::resize(level, half, cv::Size(level.cols / 2, level.rows / 2), 0, 0, cv::INTER_AREA);
    level = half;
  }
}

float Texture::SampleLevel(int level, float u, float v) const {
  const int size = size_ >> level;
  const int mask = size - 1;
  const std::uint16_t* texels = texels_.data() + offsets_[static_cast<std::size_t>(level)];
  const float x = u * static_cast<float>(size) - 0.5F;
  const float y = v * static_cast<float>(size) - 0.5F;
  const float floor_x = std::floor(x);
  const float floor_y = std::floor(y);
  const float fx = x - floor_x;
  const float fy = y - floor_y;
  const int x0 = static_cast<int>(floor_x) & mask;
  const int x1 = (x0 + 1) & mask;
  const int y0 = static_cast<int>(floor_y) & mask;
  const std::uint16_t* row0 = texels + static_cast<std::ptrdiff_t>(y0) * size;
  const std::uint16_t* row1 = texels + static_cast<std::ptrdiff_t>((y0 + 1) & mask) * size;
  const auto mix = [](float a, float b, float w) { return a + (b - a) * w; };
  const float top = mix(row0[x0], row0[x1], fx);
  const float bottom = mix(row1[x0], row1[x1], fx);
  return mix(top, bottom, fy) * (1.0F / kTexelScale);
}

float Texture::Sample(float u, float v, float footprint) const {
  const float texels = footprint * static_cast<float>(size_);
  if (!(texels > 1.0F)) {
    return SampleLevel(0, u, v);
  }
  const float level = std::min(FastLog2(texels), static_cast<float>(levels_ - 1));
  const int fine = static_cast<int>(level);
  const float weight = level - static_cast<float>(fine);
  const float value = SampleLevel(fine, u, v);
  if (weight == 0.0F) {
    return value;
  }
  return value + (SampleLevel(fine + 1, u, v) - value) * weight;
}

}  // namespace deja_view::sim
