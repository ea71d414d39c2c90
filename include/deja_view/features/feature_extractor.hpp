#pragma once

#include "deja_view/features/types.hpp"
#include "deja_view/features/vertical_field.hpp"

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
  /// size) and describes them, and `points` (pixels, e.g. the VIO's tracked points) with the same
  /// smoothed image. `point_descriptors` is resized to points.size(). Keypoints too near the border
  /// to be described are left out. Near and beyond the border the image is continued in a way that
  /// the extractor defines (BRIEF: by its nearest pixel; ORB: mirrored).
  ///
  /// With a `vertical` field, patches are described as they stand in the world; without, as they
  /// stand in the image (BRIEF), or turned as their own grey values say (ORB, always).
  ///
  /// Throws CheckError when the image is not CV_8UC1.
  virtual Features Extract(const cv::Mat& image,
                           const VerticalField& vertical,
                           const std::vector<cv::Point2f>& points,
                           std::vector<Descriptor>* point_descriptors) const = 0;

  /// The same without points.
  Features Extract(const cv::Mat& image, const VerticalField& vertical = {}) const {
    return Extract(image, vertical, {}, nullptr);
  }
};

}  // namespace deja_view
