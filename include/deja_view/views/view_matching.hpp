#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/features/types.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstddef>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// Matches between two images, judged by geometry.
struct MatchCount {
  std::size_t visible = 0;  ///< keypoints of the first whose place lies in the second image
  std::size_t matched = 0;  ///< of these, with a nearest descriptor that is near enough
  std::size_t correct = 0;  ///< of these, at their place
};

/// Finds for each keypoint of A the keypoint of B with the nearest descriptor, less than
/// `max_distance` bits away, and calls it correct within `radius_px` of where the keypoint's depth
/// puts it. `depth_A` (CV_32FC1, of A's size) is along the unit ray [m]; keypoints without depth do
/// not count. Both cameras are `camera`.
MatchCount CountCorrectMatches(const Features& A,
                               const Features& B,
                               const cv::Mat& depth_A,
                               const Camera& camera,
                               const Rigid3& T_A_B,
                               double radius_px = 3,
                               int max_distance = 80);

}  // namespace deja_view
