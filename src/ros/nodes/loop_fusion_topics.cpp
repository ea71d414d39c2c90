#include "deja_view/ros/messages/any_pose.hpp"
#include "deja_view/ros/nodes/loop_fusion_node.hpp"

#include <map>

#include <ros/console.h>
#include <ros/master.h>
#include <ros/message_traits.h>

// The poses of an odometry that gives nothing else, and the watch over what comes in.
namespace deja_view {
namespace {

nav_msgs::Odometry ToOdometry(const StampedPose& T_W_B, const FrameNames& frames) {
  nav_msgs::Odometry odometry;
  odometry.header.stamp = ToRosTime(T_W_B.stamp_ns);
  odometry.header.frame_id = frames.vio;
  odometry.child_frame_id = frames.body;
  odometry.pose.pose = ToPose(T_W_B.pose);
  return odometry;
}

}  // namespace

void LoopFusionNode::OnAnyPose(const topic_tools::ShapeShifter::ConstPtr& message) {
  const auto pose = FromAnyPose(*message, parameters_.topics.odometry);
  if (!pose) {
    ROS_INFO_ONCE("%s: not initialised yet", parameters_.topics.odometry.c_str());
    return;
  }
  fusion_->AddOdometry(pose->stamp_ns, pose->pose);
  // With the velocities, where the message has them.
  const auto odometry = internal::InstantiateIf<nav_msgs::Odometry>(*message);
  publisher_->PublishOdometry(
      odometry ? *odometry : ToOdometry(*pose, parameters_.frames), *pose, fusion_->drift());
}

void LoopFusionNode::OnStaticTransforms(const tf2_msgs::TFMessageConstPtr& message) {
  tf_->AddStatic(*message);
}

void LoopFusionNode::OnTransforms(const tf2_msgs::TFMessageConstPtr& message) {
  const auto pose = tf_->Add(*message);
  if (!pose) {
    if (!tf_->has_pose()) {
      ROS_WARN_STREAM_DELAYED_THROTTLE(TopicWatch::kAgainSeconds,
                                       "loop_fusion: " << tf_->Describe());
    }
    return;
  }
  watch_->Hear(parameters_.topics.odometry, ros::SteadyTime::now().toSec());
  fusion_->AddOdometry(pose->stamp_ns, pose->pose);
  publisher_->PublishOdometry(ToOdometry(*pose, parameters_.frames), *pose, fusion_->drift());
}

std::vector<NeededTopic> LoopFusionNode::NeededTopics() const {
  const VioTopics& topics = parameters_.topics;
  const std::string odometry = ros::message_traits::datatype<nav_msgs::Odometry>();
  std::vector<NeededTopic> needed = {
      {tf_ ? topics.odometry : handle_.resolveName(topics.odometry), odometry, true}};
  if (vins_.loop_closure) {
    needed.push_back({handle_.resolveName(topics.image),
                      parameters_.compressed_images
                          ? ros::message_traits::datatype<sensor_msgs::CompressedImage>()
                          : ros::message_traits::datatype<sensor_msgs::Image>(),
                      true});
  }
  if (vins_.loop_closure && parameters_.host != HostKind::kOdometry) {
    needed.push_back({handle_.resolveName(topics.keyframe_pose), odometry, false});
    needed.push_back({handle_.resolveName(topics.keyframe_point),
                      ros::message_traits::datatype<sensor_msgs::PointCloud>(),
                      false});
  }
  return needed;
}

void LoopFusionNode::WatchTopics(const ros::WallTimerEvent& /*event*/) {
  errors_.Guard([this] {
    const double now_s = ros::SteadyTime::now().toSec();
    if (watch_->Silent(now_s).empty()) {
      return;
    }
    ros::master::V_TopicInfo topics;
    ros::master::getTopics(topics);
    std::map<std::string, std::string> published;
    for (const ros::master::TopicInfo& topic : topics) {
      published[topic.name] = topic.datatype;
    }
    if (tf_ && published.count(TfPoses::kTopic) > 0) {
      published[parameters_.topics.odometry] = ros::message_traits::datatype<nav_msgs::Odometry>();
    }
    for (const std::string& warning : watch_->Warn(now_s, published)) {
      ROS_WARN("loop_fusion: %s", warning.c_str());
    }
  });
}

}  // namespace deja_view
