#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// Decodes an image when its turn comes, if it ever does: CV_8UC1. May throw InputError.
using ImageSource = std::function<cv::Mat()>;

/// An image that waits for its turn.
struct WaitingImage {
  std::int64_t stamp_ns = 0;
  ImageSource source;
  std::size_t bytes = 0;  ///< that the source holds in memory
};

}  // namespace deja_view
