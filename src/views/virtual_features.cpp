#include "deja_view/views/virtual_features.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

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

/// Depth [m] of a pixel; 0 where its neighbourhood has an edge and so belongs to two surfaces.
float DepthOffEdges(const cv::Mat& depth_mm, int x, int y) {
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

struct Depth {
  float metres = 0;
  float sigma_m = 0;
};

/// The image's features where `is_seen(x, y)` of their pixel, with `depth_at(x, y)` there.
template <typename IsSeen, typename DepthAt>
VirtualFeatures Collect(const cv::Mat& image,
                        const FeatureExtractor& extractor,
                        const VerticalField& vertical,
                        const IsSeen& is_seen,
                        const DepthAt& depth_at) {
  const Features all = extractor.Extract(image, vertical);
  VirtualFeatures result;
  result.descriptor = extractor.DescriptorName();
  for (std::size_t i = 0; i < all.keypoints.size(); ++i) {
    const Keypoint& keypoint = all.keypoints[i];
    const int x = std::clamp(static_cast<int>(std::lround(keypoint.x)), 0, image.cols - 1);
    const int y = std::clamp(static_cast<int>(std::lround(keypoint.y)), 0, image.rows - 1);
    if (!is_seen(x, y)) {
      continue;
    }
    const Depth depth = depth_at(x, y);
    result.features.keypoints.push_back(keypoint);
    result.features.descriptors.push_back(all.descriptors[i]);
    result.depth_m.push_back(depth.metres);
    result.depth_sigma_m.push_back(depth.sigma_m);
  }
  return result;
}

}  // namespace

VirtualFeatures ExtractVirtualFeatures(const RenderedView& view,
                                       const FeatureExtractor& extractor,
                                       const VerticalField& vertical,
                                       double min_opacity) {
  const cv::Size size = view.image.size();
  DEJA_VIEW_CHECK(view.depth.size() == size && view.depth_variance.size() == size &&
                  view.opacity.size() == size);
  const auto least = static_cast<float>(min_opacity);
  return Collect(
      view.image,
      extractor,
      vertical,
      [&](int x, int y) { return view.opacity.at<float>(y, x) >= least; },
      [&](int x, int y) {
        const float depth = view.depth.at<float>(y, x);
        const float variance =
            depth > 0 ? view.depth_variance.at<float>(y, x) + VarianceAround(view.depth, x, y)
                      : 0.0F;
        return Depth{depth, std::sqrt(variance)};
      });
}

VirtualFeatures ExtractVirtualFeatures(const VirtualView& view,
                                       const FeatureExtractor& extractor,
                                       const VerticalField& vertical,
                                       double min_certainty) {
  const auto least = static_cast<std::uint8_t>(std::lround(255 * min_certainty));
  return Collect(
      view.image,
      extractor,
      vertical,
      [&](int x, int y) {
        return view.certainty.empty() || view.certainty.at<std::uint8_t>(y, x) >= least;
      },
      [&](int x, int y) {
        return view.depth_mm.empty() ? Depth{} : Depth{DepthOffEdges(view.depth_mm, x, y), 0.0F};
      });
}

}  // namespace deja_view
