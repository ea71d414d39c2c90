#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace deja_view {

/// A point that the VIO tracks, as seen in one keyframe.
struct TrackedPoint {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< [m] in the VIO's world
  Eigen::Vector2f pixel =
      Eigen::Vector2f::Zero();   ///< [px] in the keyframe's image, as the VIO tracked it
  std::int64_t feature_id = -1;  ///< the VIO's id of the track
};

/// What the VIO hands over for one keyframe; all of one stamp.
struct KeyframeInput {
  std::int64_t stamp_ns = 0;
  Rigid3 T_W_B;                      ///< body pose in the VIO's (drifting) world
  cv::Mat image;                     ///< CV_8UC1, the camera's size
  std::vector<TrackedPoint> points;  ///< may be empty
  /// The image stream paused for long or the VIO started anew since the keyframe before.
  bool starts_sequence = false;
};

}  // namespace deja_view
