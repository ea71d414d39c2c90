#pragma once

#include "deja_view/bundle/bundle_problem.hpp"
#include "deja_view/features/feature_extractor.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace deja_view {

/// A pixel that the VIO tracks.
struct BundleTrackedPixel {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< [px]
  std::int64_t track_id = -1;
};

/// Fills keypoints, descriptors and track ids of `image` from the picture `grey` (CV_8UC1): the
/// VIO's pixels first, then the corners of `extractor` that lie no nearer than 4 px to one of
/// them, moved to their sub-pixel positions.
void DescribeImage(const cv::Mat& grey,
                   const std::vector<BundleTrackedPixel>& tracked,
                   const FeatureExtractor& extractor,
                   BundleImage* image);

}  // namespace deja_view
