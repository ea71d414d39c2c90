#include "deja_view/lab/sim/texture.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace deja_view::sim {
namespace {

/// 255 sqrt(reflectance), rounded.
std::vector<std::uint8_t> Encode(const cv::Mat& level) {
  std::vector<std::uint8_t> codes;
  for (int y = 0; y < level.rows; ++y) {
    for (int x = 0; x < level.cols; ++x) {
      const float value = std::clamp(level.at<float>(y, x), 0.0F, 1.0F);
      codes.push_back(static_cast<std::uint8_t>(std::lround(255.0F * std::sqrt(value))));
    }
  }
  return codes;
}

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
    const int n = level.cols;
    const std::vector<std::uint8_t> codes = Encode(level);
    const auto code = [&](int x, int y) {
      return std::uint32_t{codes[static_cast<std::size_t>(y % n * n + x % n)]};
    };
    offsets_.push_back(static_cast<std::int32_t>(texels_.size()));
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        texels_.push_back(code(x, y) | code(x + 1, y) << 8U | code(x, y + 1) << 16U |
                          code(x + 1, y + 1) << 24U);
      }
    }
    ++levels_;
    if (n == 1) {
      break;
    }
    cv::Mat half;
    cv::resize(level, half, cv::Size(n / 2, n / 2), 0, 0, cv::INTER_AREA);
    level = half;
  }
}

float Texture::SampleLevel(int level, float u, float v) const {
  const int size = size_ >> level;
  const float x = u * static_cast<float>(size) - 0.5F;
  const float y = v * static_cast<float>(size) - 0.5F;
  const float floor_x = std::floor(x);
  const float floor_y = std::floor(y);
  const float fx = x - floor_x;
  const float fy = y - floor_y;
  const int column = static_cast<int>(floor_x) & (size - 1);
  const int row = static_cast<int>(floor_y) & (size - 1);
  const std::uint32_t quad = texels_[static_cast<std::size_t>(
      offsets_[static_cast<std::size_t>(level)] + row * size + column)];
  const auto decode = [&](unsigned shift) {
    const float root = static_cast<float>((quad >> shift) & 255U) * (1.0F / 255.0F);
    return root * root;
  };
  const float top = decode(0) + (decode(8) - decode(0)) * fx;
  const float bottom = decode(16) + (decode(24) - decode(16)) * fx;
  return top + (bottom - top) * fy;
}

float Texture::Sample(float u, float v, float footprint) const {
  const float texels = std::max(1.0F, footprint * static_cast<float>(size_));
  const float level = std::min(FastLog2(texels), static_cast<float>(levels_ - 1));
  const int fine = static_cast<int>(level);
  const int coarse = std::min(fine + 1, levels_ - 1);
  const float value = SampleLevel(fine, u, v);
  return value + (SampleLevel(coarse, u, v) - value) * (level - static_cast<float>(fine));
}

}  // namespace deja_view::sim
