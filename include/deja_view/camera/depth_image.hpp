#pragma once

#include <cmath>
#include <cstdint>

#include <opencv2/core.hpp>

namespace deja_view {

/// Depths or ranges [m] (CV_32FC1) as 16-bit millimetres, the usual form of a depth image in files
/// and messages; 0 where there is none, or too far for 16 bits.
inline cv::Mat ToMillimetres(const cv::Mat& metres) {
  cv::Mat millimetres(metres.size(), CV_16UC1);
  for (int y = 0; y < metres.rows; ++y) {
    for (int x = 0; x < metres.cols; ++x) {
      const float value = 1000.0F * metres.at<float>(y, x);
      millimetres.at<std::uint16_t>(y, x) =
          value < 65535.0F ? static_cast<std::uint16_t>(std::lround(value)) : std::uint16_t{0};
    }
  }
  return millimetres;
}

}  // namespace deja_view
