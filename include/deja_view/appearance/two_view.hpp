#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/features/types.hpp"

#include <string>
#include <vector>

namespace deja_view {

/// How two images are compared by their geometry alone.
struct TwoViewOptions {
  int max_distance = 80;           ///< [bits] between matched descriptors, 1 to 256
  double max_ratio = 0.85;         ///< nearest over second nearest distance, above 0, at most 1
  double max_error_px = 2.0;       ///< distance to the epipolar line, above 0
  double confidence = 0.999;       ///< of the sampling, in (0, 1)
  int max_iterations = 2000;       ///< of the fundamental matrix, where OpenCV can be told; >= 1
  const Camera* camera = nullptr;  ///< essential matrix where given, else fundamental; not owned

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;
};

/// What two images have in common.
struct TwoViewResult {
  int matches = 0;  ///< mutually nearest descriptors
  int inliers = 0;  ///< of these, those that one epipolar geometry explains
};

/// Mutually nearest descriptors with a ratio test, and the epipolar geometry that most of them
/// obey, by OpenCV's sampling. With a camera, pixels are undistorted first and what lies more than
/// 80 degrees off the axis is left out. Deterministic. Throws CheckError for invalid options.
TwoViewResult CompareTwoViews(const Features& a,
                              const Features& b,
                              const TwoViewOptions& options = {});

}  // namespace deja_view
