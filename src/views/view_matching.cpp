#include "deja_view/views/view_matching.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/hamming_matcher.hpp"

#include <cmath>

namespace deja_view {

MatchCount CountCorrectMatches(const Features& A,
                               const Features& B,
                               const cv::Mat& depth_A,
                               const Camera& camera,
                               const Rigid3& T_A_B,
                               double radius_px,
                               int max_distance) {
  DEJA_VIEW_CHECK(depth_A.type() == CV_32FC1 && depth_A.cols == camera.width() &&
                  depth_A.rows == camera.height());
  const Rigid3 T_B_A = T_A_B.Inverse();
  const std::vector<HammingMatch> matches =
      MatchHamming(A.descriptors, B.descriptors, max_distance - 1);
  MatchCount count;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Keypoint& from = A.keypoints[i];
    const auto depth = static_cast<double>(depth_A.at<float>(
        static_cast<int>(std::lround(from.y)), static_cast<int>(std::lround(from.x))));
    if (!(depth > 0)) {
      continue;
    }
    const auto place = camera.Project(T_B_A * (depth * camera.Unproject({from.x, from.y})));
    if (!place || !camera.IsInImage(*place)) {
      continue;
    }
    ++count.visible;
    if (matches[i].best < 0) {
      continue;
    }
    ++count.matched;
    const Keypoint& to = B.keypoints[static_cast<std::size_t>(matches[i].best)];
    count.correct += (*place - Eigen::Vector2d(to.x, to.y)).norm() <= radius_px ? 1U : 0U;
  }
  return count;
}

}  // namespace deja_view
