#pragma once

#include <functional>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// Decodes an image when its turn comes, if it ever does: CV_8UC1. May throw InputError.
using ImageSource = std::function<cv::Mat()>;

}  // namespace deja_view
