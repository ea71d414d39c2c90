#include "deja_view/host/host_kind.hpp"

#include "deja_view/base/check.hpp"

namespace deja_view {

VioTopics TopicsOf(HostKind host) {
  VioTopics topics;
  switch (host) {
    case HostKind::kVinsMono:
      break;
    case HostKind::kVinsFusion:
      topics.relo_relative_pose.clear();
      break;
    case HostKind::kOpenVins:
      topics.keyframe_pose = "/ov_msckf/loop_pose";
      topics.keyframe_point = "/ov_msckf/loop_feats";
      topics.extrinsic = "/ov_msckf/loop_extrinsic";
      topics.odometry = "/ov_msckf/odomimu";
      topics.imu_propagate.clear();
      topics.relo_relative_pose.clear();
      break;
    case HostKind::kOdometry:
      topics.keyframe_pose.clear();
      topics.keyframe_point.clear();
      topics.extrinsic.clear();
      topics.odometry = "/odometry";
      topics.imu_propagate.clear();
      topics.relo_relative_pose.clear();
      break;
  }
  return topics;
}

void CheckGravity(HostKind host, GravityPolicy gravity, const std::string& option) {
  if (gravity == GravityPolicy::kEstimate && host != HostKind::kOdometry) {
    ThrowInputError(
        "{}: estimate goes with the host odometry only, not {}", option, EnumToString(host));
  }
}

}  // namespace deja_view
