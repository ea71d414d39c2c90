#pragma once

#include <string>

namespace deja_view {

/// Topics that VINS-Mono publishes and the loop closer reads.
struct VioTopics {
  std::string image = "/cam0/image_raw";
  std::string keyframe_pose = "/vins_estimator/keyframe_pose";
  std::string keyframe_point = "/vins_estimator/keyframe_point";
  std::string extrinsic = "/vins_estimator/extrinsic";
  std::string odometry = "/vins_estimator/odometry";
  std::string imu_propagate = "/vins_estimator/imu_propagate";
  std::string relo_relative_pose = "/vins_estimator/relo_relative_pose";
  std::string virtual_frame = "/virtual_cam0/frame";  ///< not VINS-Mono's: rendered views
};

}  // namespace deja_view
