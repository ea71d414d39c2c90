#pragma once

#include "deja_view/fusion/loop_fusion_options.hpp"
#include "deja_view/fusion/match_image.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/pipeline/loop_closer.hpp"
#include "deja_view/ros/messages/conversions.hpp"
#include "deja_view/ros/messages/output_messages.hpp"

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_ros/transform_broadcaster.h>

namespace deja_view {

/// The node's outputs: VINS-Mono's topics under one namespace (`/pose_graph`), its own under the
/// node's name. What is costly is made only when somebody listens.
class LoopPublisher {
 public:
  LoopPublisher(ros::NodeHandle vins_handle,
                ros::NodeHandle private_handle,
                const FrameNames& frames,
                const VinsConfig& vins,
                const NodeOptions& options);

  /// Loops, relocalisation, drift and match image of a keyframe; from the worker thread.
  void PublishKeyframe(const KeyframeInput& input,
                       const KeyframeReport& report,
                       const Rigid3& T_M_W);

  /// Corrected odometry, tf and camera pyramid, at the VIO's rate.
  void PublishOdometry(const nav_msgs::Odometry& message,
                       const StampedPose& T_W_B,
                       const Rigid3& T_M_W);

  /// Corrected IMU-rate odometry.
  void PublishImuPropagate(const nav_msgs::Odometry& message,
                           const StampedPose& T_W_B,
                           const Rigid3& T_M_W);

  /// True when paths changed, or found a new listener, since the last call; and somebody listens.
  bool WantsPaths();

  /// Paths and markers of the whole map; sequences below `first_own_sequence` are a loaded map's.
  void PublishPaths(const std::vector<KeyframeInfo>& keyframes,
                    const std::vector<LoopReport>& loops,
                    int first_own_sequence);

 private:
  static constexpr int kPathCount = 9;  ///< path_1 to path_9, as VINS-Mono

  template <typename Message>
  ros::Publisher AdvertiseMapOutput(ros::NodeHandle& handle, const std::string& topic);
  void PublishMatchImage(const KeyframeInput& input, const KeyframeReport& report);

  FrameNames frames_;
  VinsConfig vins_;
  MatchImages match_images_;
  std::atomic<bool> paths_changed_{false};

  ros::Publisher match_points_;
  ros::Publisher pose_graph_path_;
  ros::Publisher base_path_;
  std::vector<ros::Publisher> paths_;
  ros::Publisher pose_graph_;
  ros::Publisher match_image_;
  ros::Publisher camera_pose_visual_;
  ros::Publisher key_odometrys_;
  ros::Publisher no_loop_path_;

  ros::Publisher loop_constraint_;
  ros::Publisher drift_;
  ros::Publisher odometry_corrected_;
  ros::Publisher imu_propagate_corrected_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace deja_view
