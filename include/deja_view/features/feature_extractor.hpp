#pragma once

#include "deja_view/features/types.hpp"

#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// Turns a grey image into keypoints and 256-bit descriptors. Deterministic; const methods may be
/// called from several threads.
class FeatureExtractor {
 public:
  virtual ~FeatureExtractor() = default;

  /// "brief" or "orb"; a vocabulary is trained for one of them.
  virtual std::string DescriptorName() const = 0;

  /// Detects at most `max_features` corners (an option of the extractor) in `image` (CV_8UC1, any
  /// size) and describes them. Keypoints too near the border to be described are left out. Throws
  /// CheckError when the image is not CV_8UC1.
  virtual Features Extract(const cv::Mat& image) const = 0;

  /// As Extract, and also describes `points` (pixels, e.g. the VIO's tracked points) with the same
  /// smoothed image. `point_descriptors` is resized to points.size(). Near and beyond the border
  /// the image is continued in a way that the extractor defines (BRIEF: by its nearest pixel; ORB:
  /// mirrored).
  virtual Features Extract(const cv::Mat& image,
                           const std::vector<cv::Point2f>& points,
                           std::vector<Descriptor>* point_descriptors) const = 0;
};

}  // namespace deja_view
