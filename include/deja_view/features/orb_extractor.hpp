#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/features/feature_options.hpp"

namespace deja_view {

/// ORB (Rublee et al., ICCV 2011) as ORB-SLAM extracts it: on every level of a pyramid, FAST
/// corners spread by a quadtree, oriented by their intensity centroid, with rotated BRIEF.
///
/// The descriptor is OpenCV's: level l is level l - 1 resized (`INTER_LINEAR_EXACT`) to the image's
/// size over scale_factor^l, smoothed with a 7 x 7 Gaussian of sigma 2 px, and `cv::ORB` describes
/// the corner with its angle. Positions map between levels with pixel centres kept, full = (level +
/// 0.5) s - 0.5, where OpenCV and ORB-SLAM scale the coordinate itself. Points to be described are
/// taken on the full resolution, oriented in the same way, on the image mirrored beyond its border.
class OrbExtractor final : public FeatureExtractor {
 public:
  /// Throws CheckError for invalid options.
  explicit OrbExtractor(const OrbOptions& options = {});

  std::string DescriptorName() const override { return "orb"; }
  using FeatureExtractor::Extract;
  Features Extract(const cv::Mat& image,
                   const VerticalField& vertical,
                   const std::vector<cv::Point2f>& points,
                   std::vector<Descriptor>* point_descriptors) const override;

 private:
  OrbOptions options_;
  std::vector<int> level_features_;  // share of max_features per level
};

namespace internal {

/// Direction from the pixel to the intensity centroid of the disc of radius 15 around it [deg],
/// clockwise in the image, in [0, 360). The disc must lie in the image.
float IntensityCentroidAngle(const cv::Mat& image, cv::Point centre);

}  // namespace internal
}  // namespace deja_view
