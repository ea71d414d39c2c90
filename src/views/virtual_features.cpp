#include "deja_view/views/virtual_features.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view {
namespace {

/// Variance of the known depths in the 3 x 3 pixels around (x, y) [m^2].
float VarianceAround(const cv::Mat& depth, int x, int y) {
  float sum = 0;
  float sum_squared = 0;
  float count = 0;
  const float centre = depth.at<float>(y, x);
  for (int v = std::max(0, y - 1); v <= std::min(depth.rows - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(depth.cols - 1, x + 1); ++u) {
      const float d = depth.at<float>(v, u);
      if (d > 0) {
        sum += d - centre;
        sum_squared += (d - centre) * (d - centre);
        count += 1;
      }
    }
  }
  const float mean = sum / count;
  return std::max(0.0F, sum_squared / count - mean * mean);
}

}  // namespace

VirtualFeatures ExtractVirtualFeatures(const RenderedView& view,
                                       const FeatureExtractor& extractor,
                                       double min_opacity) {
  const cv::Size size = view.image.size();
  DEJA_VIEW_CHECK(view.depth.size() == size && view.depth_variance.size() == size &&
                  view.opacity.size() == size);
  const Features all = extractor.Extract(view.image);
  VirtualFeatures result;
  result.descriptor = extractor.DescriptorName();
  for (std::size_t i = 0; i < all.keypoints.size(); ++i) {
    const Keypoint& keypoint = all.keypoints[i];
    const int x = std::clamp(static_cast<int>(std::lround(keypoint.x)), 0, size.width - 1);
    const int y = std::clamp(static_cast<int>(std::lround(keypoint.y)), 0, size.height - 1);
    if (view.opacity.at<float>(y, x) < static_cast<float>(min_opacity)) {
      continue;
    }
    result.features.keypoints.push_back(keypoint);
    result.features.descriptors.push_back(all.descriptors[i]);
    const float depth = view.depth.at<float>(y, x);
    result.depth_m.push_back(depth);
    const float variance =
        depth > 0 ? view.depth_variance.at<float>(y, x) + VarianceAround(view.depth, x, y) : 0.0F;
    result.depth_sigma_m.push_back(std::sqrt(variance));
  }
  return result;
}

}  // namespace deja_view
