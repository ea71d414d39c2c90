#pragma once

#include "deja_view/base/output_lock.hpp"
#include "deja_view/fusion/loop_fusion.hpp"
#include "deja_view/fusion/map_directory.hpp"
#include "deja_view/fusion/match_samples.hpp"
#include "deja_view/fusion/result_files.hpp"
#include "deja_view/host/topic_watch.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/ros/messages/tf_poses.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"
#include "deja_view/ros/nodes/loop_publisher.hpp"
#include "deja_view/ros/nodes/node_parameters.hpp"

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <deja_view/NamedMap.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <topic_tools/shape_shifter.h>

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <ros/spinner.h>
#include <ros/subscriber.h>
#include <ros/wall_timer.h>

namespace deja_view {

/// The drop-in for VINS-Mono's pose_graph node: topics in, LoopFusion, topics out. Messages are
/// taken in by the thread that calls Run, keyframes are processed by LoopFusion's worker, services,
/// paths and diagnostics have a thread of their own.
class LoopFusionNode {
 public:
  /// Reads parameters and files, and loads a map when told to. Throws InputError when one of them
  /// can't be used.
  LoopFusionNode();
  ~LoopFusionNode();

  /// Runs until `stop` is set or ROS shuts down; then finishes what waits, within
  /// NodeOptions::drain_s, and writes results and map when told to. Returns the exit code. Throws
  /// what broke an invariant, on any thread (ErrorPolicy).
  int Run(const std::atomic<bool>& stop);

 private:
  LoopCloser MakeLoopCloser() const;
  std::unique_ptr<LoopFusion> MakeLoopFusion();
  void LoadAtStart();
  void Subscribe();
  void Advertise();
  template <typename Message>
  void SubscribeTo(const std::string& topic,
                   std::uint32_t queue,
                   void (LoopFusionNode::*handle)(const boost::shared_ptr<const Message>&));

  cv::Size ImageSize() const { return {vins_.camera->width(), vins_.camera->height()}; }
  template <typename Message>
  void AddImage(const Message& message, ImageSource image) {
    fusion_->AddImage(ToNanoseconds(message.header.stamp), std::move(image), message.data.size());
  }
  void OnImage(const sensor_msgs::ImageConstPtr& message);
  void OnCompressedImage(const sensor_msgs::CompressedImageConstPtr& message);
  void OnKeyframePose(const nav_msgs::OdometryConstPtr& message);
  void OnKeyframePoints(const sensor_msgs::PointCloudConstPtr& message);
  void OnExtrinsic(const nav_msgs::OdometryConstPtr& message);
  void OnAnyPose(const topic_tools::ShapeShifter::ConstPtr& message);
  void OnTransforms(const tf2_msgs::TFMessageConstPtr& message);
  void OnStaticTransforms(const tf2_msgs::TFMessageConstPtr& message);
  void OnOdometry(const nav_msgs::OdometryConstPtr& message);
  void OnImuPropagate(const nav_msgs::OdometryConstPtr& message);
  void OnRelativePose(const nav_msgs::OdometryConstPtr& message);
  void OnVirtualFrame(const VirtualFrameConstPtr& message);

  bool SaveMap(NamedMap::Request& request, NamedMap::Response& response);
  bool LoadMap(NamedMap::Request& request, NamedMap::Response& response);
  void Load(const std::filesystem::path& map);
  void PublishPaths(const ros::WallTimerEvent& event);
  std::vector<NeededTopic> NeededTopics() const;
  void WatchTopics(const ros::WallTimerEvent& event);
  void Diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);
  static void OnProblem(const std::string& what);
  bool HasFailed() const { return errors_.has_failed() || fusion_->errors().has_failed(); }
  bool Finish();

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_{"~"};
  ros::CallbackQueue service_queue_;
  ros::NodeHandle service_handle_{"~"};

  NodeParameters parameters_;
  VinsConfig vins_;
  LoopFusionOptions options_;
  MapDirectory maps_;
  std::vector<OutputLock> locks_;  ///< of what is written at the end
  std::optional<TfPoses> tf_;      ///< where the odometry's poses are between two frames
  std::unique_ptr<LoopPublisher> publisher_;
  std::unique_ptr<LoopFusion> fusion_;
  // Guarded by LoopFusion::WithLoopCloser, as on_keyframe is.
  int first_own_sequence_ = 0;
  int first_own_keyframe_ = 0;
  LoopRows loops_{parameters_.output_directory};
  MatchSamples matches_;

  ErrorPolicy errors_{[this](const std::string& what) { OnProblem(what); }};  ///< of all callbacks
  std::unique_ptr<TopicWatch> watch_;
  LoopFusionStatistics diagnosed_;  ///< at the last diagnosis
  std::int64_t diagnosed_bad_messages_ = 0;
  ros::WallTime diagnosed_at_;

  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  std::vector<ros::WallTimer> timers_;
  std::unique_ptr<diagnostic_updater::Updater> diagnostics_;
  std::unique_ptr<ros::AsyncSpinner> service_spinner_;
};

}  // namespace deja_view
