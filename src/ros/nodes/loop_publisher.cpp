#include "deja_view/ros/nodes/loop_publisher.hpp"

#include <algorithm>
#include <iterator>

#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud.h>

namespace deja_view {
namespace {

constexpr std::uint32_t kQueue = 100;

// A join tells of thousands of loops at once, and none may be lost.
constexpr std::uint32_t kUnbounded = 0;

std::vector<KeyframeInfo> OfSequences(const std::vector<KeyframeInfo>& keyframes,
                                      int first,
                                      int last) {
  std::vector<KeyframeInfo> selected;
  std::copy_if(keyframes.begin(),
               keyframes.end(),
               std::back_inserter(selected),
               [first, last](const KeyframeInfo& keyframe) {
                 return keyframe.sequence >= first && keyframe.sequence <= last;
               });
  return selected;
}

}  // namespace

LoopPublisher::LoopPublisher(ros::NodeHandle vins_handle,
                             ros::NodeHandle private_handle,
                             const FrameNames& frames,
                             const VinsConfig& vins,
                             const NodeOptions& options)
    : frames_(frames),
      vins_(vins),
      match_images_(options.match_image ? options.match_image_memory : 0) {
  match_points_ = vins_handle.advertise<sensor_msgs::PointCloud>("match_points", kQueue);
  pose_graph_path_ = AdvertiseMapOutput<nav_msgs::Path>(vins_handle, "pose_graph_path");
  base_path_ = AdvertiseMapOutput<nav_msgs::Path>(vins_handle, "base_path");
  no_loop_path_ = AdvertiseMapOutput<nav_msgs::Path>(vins_handle, "no_loop_path");
  for (int i = 1; i <= kPathCount; ++i) {
    paths_.push_back(AdvertiseMapOutput<nav_msgs::Path>(vins_handle, "path_" + std::to_string(i)));
  }
  pose_graph_ = AdvertiseMapOutput<visualization_msgs::MarkerArray>(vins_handle, "pose_graph");
  key_odometrys_ = AdvertiseMapOutput<visualization_msgs::Marker>(vins_handle, "key_odometrys");
  match_image_ = vins_handle.advertise<sensor_msgs::Image>("match_image", kQueue);
  camera_pose_visual_ =
      vins_handle.advertise<visualization_msgs::MarkerArray>("camera_pose_visual", kQueue);

  loop_constraint_ = private_handle.advertise<LoopConstraint>("loop_constraint", kUnbounded);
  drift_ = private_handle.advertise<geometry_msgs::TransformStamped>("drift", kQueue);
  odometry_corrected_ = private_handle.advertise<nav_msgs::Odometry>("odometry_corrected", kQueue);
  imu_propagate_corrected_ =
      private_handle.advertise<nav_msgs::Odometry>("imu_propagate_corrected", kQueue);
}

template <typename Message>
ros::Publisher LoopPublisher::AdvertiseMapOutput(ros::NodeHandle& handle,
                                                 const std::string& topic) {
  return handle.advertise<Message>(
      topic, 2, [this](const ros::SingleSubscriberPublisher&) { paths_changed_ = true; });
}

void LoopPublisher::PublishKeyframe(const KeyframeInput& input,
                                    const KeyframeReport& report,
                                    const Rigid3& T_M_W) {
  paths_changed_ = true;
  for (const LoopReport& loop : report.loops) {
    loop_constraint_.publish(ToLoopConstraint(loop, frames_));
  }
  if (report.relocalisation && vins_.fast_relocalization) {
    match_points_.publish(
        ToMatchPoints(*report.relocalisation, report.index, input.stamp_ns, frames_.map));
  }
  drift_.publish(ToDrift(T_M_W, input.stamp_ns, frames_));
  match_images_.Add(report.index, input.image);
  PublishMatchImage(input, report);
}

void LoopPublisher::PublishMatchImage(const KeyframeInput& input, const KeyframeReport& report) {
  if (!report.relocalisation || match_image_.getNumSubscribers() == 0) {
    return;
  }
  const auto image = match_images_.Draw(input, report.index, *report.relocalisation, *vins_.camera);
  if (image) {
    match_image_.publish(ToImage(*image, input.stamp_ns, frames_.body));
  }
}

void LoopPublisher::PublishOdometry(const nav_msgs::Odometry& message,
                                    const StampedPose& T_W_B,
                                    const Rigid3& T_M_W) {
  odometry_corrected_.publish(CorrectOdometry(message, T_W_B, T_M_W, frames_));
  broadcaster_.sendTransform({ToDrift(T_M_W, T_W_B.stamp_ns, frames_),
                              ToCorrectedBody(T_M_W * T_W_B.pose, T_W_B.stamp_ns, frames_)});
  if (camera_pose_visual_.getNumSubscribers() > 0) {
    camera_pose_visual_.publish(ToCameraMarkers(T_M_W * T_W_B.pose * vins_.T_B_C,
                                                *vins_.camera,
                                                vins_.visualize_camera_size,
                                                T_W_B.stamp_ns,
                                                frames_));
  }
}

void LoopPublisher::PublishImuPropagate(const nav_msgs::Odometry& message,
                                        const StampedPose& T_W_B,
                                        const Rigid3& T_M_W) {
  if (imu_propagate_corrected_.getNumSubscribers() > 0) {
    imu_propagate_corrected_.publish(CorrectOdometry(message, T_W_B, T_M_W, frames_));
  }
}

bool LoopPublisher::WantsPaths() {
  const auto has_listener = [](const ros::Publisher& p) { return p.getNumSubscribers() > 0; };
  return (has_listener(pose_graph_path_) || has_listener(base_path_) ||
          has_listener(no_loop_path_) || has_listener(pose_graph_) ||
          has_listener(key_odometrys_) ||
          std::any_of(paths_.begin(), paths_.end(), has_listener)) &&
         paths_changed_.exchange(false);
}

void LoopPublisher::PublishPaths(const std::vector<KeyframeInfo>& keyframes,
                                 const std::vector<LoopReport>& loops,
                                 int first_own_sequence) {
  const int current = keyframes.empty() ? 0 : keyframes.back().sequence;
  const std::vector<KeyframeInfo> newest = OfSequences(keyframes, current, current);
  pose_graph_path_.publish(ToPath(newest, false, frames_));
  no_loop_path_.publish(ToPath(newest, true, frames_));
  base_path_.publish(ToPath(OfSequences(keyframes, 0, first_own_sequence - 1), false, frames_));
  for (int i = 0; i < kPathCount; ++i) {
    const ros::Publisher& path = paths_[static_cast<std::size_t>(i)];
    const int sequence = first_own_sequence + i;
    if (path.getNumSubscribers() > 0 && sequence <= current) {
      path.publish(ToPath(OfSequences(keyframes, sequence, sequence), false, frames_));
    }
  }
  pose_graph_.publish(ToPoseGraphMarkers(keyframes, loops, frames_));
  key_odometrys_.publish(ToKeyframeMarker(newest, frames_));
}

}  // namespace deja_view
