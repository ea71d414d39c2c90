#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>

namespace deja_view {

/// Pose of a message with its stamp.
struct StampedPose {
  std::int64_t stamp_ns = 0;
  Rigid3 pose;
};

/// Content of `/vins_estimator/relo_relative_pose`: the VIO's own measurement of a loop that it was
/// told of by `/pose_graph/match_points`.
struct RelativePoseUpdate {
  std::int64_t stamp_current_ns = 0;
  int current = -1;           ///< index of the current keyframe, as sent in match_points
  Rigid3 T_Bold_Bcurrent;     ///< [m]
  double relative_yaw = 0.0;  ///< [rad], yaw of the current minus yaw of the old keyframe
};

}  // namespace deja_view
