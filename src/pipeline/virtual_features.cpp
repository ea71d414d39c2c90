#include "deja_view/pipeline/virtual_features.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace deja_view {
namespace {

/// Depth [m] of a pixel; 0 where its neighbourhood has an edge and so belongs to two surfaces.
float DepthAt(const cv::Mat& depth_mm, int x, int y) {
  constexpr int kRadius = 2;
  constexpr float kEdge = 0.1F;  ///< of the depth
  std::uint16_t low = 65535;
  std::uint16_t high = 0;
  for (int v = std::max(0, y - kRadius); v <= std::min(depth_mm.rows - 1, y + kRadius); ++v) {
    for (int u = std::max(0, x - kRadius); u <= std::min(depth_mm.cols - 1, x + kRadius); ++u) {
      low = std::min(low, depth_mm.at<std::uint16_t>(v, u));
      high = std::max(high, depth_mm.at<std::uint16_t>(v, u));
    }
  }
  const auto depth = static_cast<float>(depth_mm.at<std::uint16_t>(y, x));
  return low == 0 || static_cast<float>(high - low) > kEdge * depth ? 0.0F : 1e-3F * depth;
}

}  // namespace

VirtualFeatures ExtractVirtualFeatures(const VirtualView& view,
                                       const FeatureExtractor& extractor,
                                       double min_certainty) {
  const Features extracted = extractor.Extract(view.image);
  const auto least = static_cast<std::uint8_t>(std::lround(255 * min_certainty));
  VirtualFeatures result;
  result.descriptor = extractor.DescriptorName();
  for (std::size_t i = 0; i < extracted.keypoints.size(); ++i) {
    const Keypoint& keypoint = extracted.keypoints[i];
    const int x = std::clamp(static_cast<int>(std::lround(keypoint.x)), 0, view.image.cols - 1);
    const int y = std::clamp(static_cast<int>(std::lround(keypoint.y)), 0, view.image.rows - 1);
    if (!view.certainty.empty() && view.certainty.at<std::uint8_t>(y, x) < least) {
      continue;
    }
    result.features.keypoints.push_back(keypoint);
    result.features.descriptors.push_back(extracted.descriptors[i]);
    result.depth_m.push_back(view.depth_mm.empty() ? 0.0F : DepthAt(view.depth_mm, x, y));
    result.depth_sigma_m.push_back(0.0F);
  }
  return result;
}

}  // namespace deja_view
