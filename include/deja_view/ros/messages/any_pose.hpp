#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/message_traits.h>

namespace deja_view {

/// Types of the messages that FromAnyPose reads.
inline const std::vector<std::string>& PoseMessageTypes() {
  static const std::vector<std::string> kTypes = {"nav_msgs/Odometry",
                                                  "geometry_msgs/PoseStamped",
                                                  "geometry_msgs/PoseWithCovarianceStamped",
                                                  "geometry_msgs/TransformStamped"};
  return kTypes;
}

namespace internal {

/// Nothing for another type; a ShapeShifter would throw.
template <typename Pose, typename Message>
boost::shared_ptr<const Pose> InstantiateIf(const Message& message) {
  return message.getDataType() == ros::message_traits::datatype<Pose>()
             ? message.template instantiate<Pose>()
             : nullptr;
}

}  // namespace internal

/// `message` is a rosbag::MessageInstance or a topic_tools::ShapeShifter. Nothing for an odometry
/// that is not initialised yet. Throws InputError for other types and for bad poses.
template <typename Message>
std::optional<StampedPose> FromAnyPose(const Message& message, const std::string& topic) {
  using internal::InstantiateIf;
  if (const auto odometry = InstantiateIf<nav_msgs::Odometry>(message)) {
    return IsUninitialised(*odometry) ? std::nullopt
                                      : std::optional(FromOdometry(*odometry, topic));
  }
  if (const auto pose = InstantiateIf<geometry_msgs::PoseStamped>(message)) {
    return StampedPose{ToNanoseconds(pose->header.stamp), FromPose(pose->pose, topic)};
  }
  if (const auto pose = InstantiateIf<geometry_msgs::PoseWithCovarianceStamped>(message)) {
    return StampedPose{ToNanoseconds(pose->header.stamp), FromPose(pose->pose.pose, topic)};
  }
  if (const auto transform = InstantiateIf<geometry_msgs::TransformStamped>(message)) {
    geometry_msgs::Pose pose;
    pose.position.x = transform->transform.translation.x;
    pose.position.y = transform->transform.translation.y;
    pose.position.z = transform->transform.translation.z;
    pose.orientation = transform->transform.rotation;
    return StampedPose{ToNanoseconds(transform->header.stamp), FromPose(pose, topic)};
  }
  ThrowInputError("{}: message of type {}: expected {}",
                  topic,
                  message.getDataType(),
                  fmt::join(PoseMessageTypes(), ", "));
}

}  // namespace deja_view
