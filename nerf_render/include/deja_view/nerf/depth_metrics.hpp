#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view::nerf {

/// |rendered - real| / real at the pixels of `rendered` (CV_32FC1, 0: nothing there, an error of 1)
/// where `real` (CV_32FC1, any size of the same view, 0: unknown) has a depth at the nearest pixel.
std::vector<float> RelativeDepthErrors(const cv::Mat& real, const cv::Mat& rendered);

}  // namespace deja_view::nerf
