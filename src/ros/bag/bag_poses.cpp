#include "deja_view/ros/bag/bag_poses.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>

namespace deja_view {
namespace {

StampedPose ReadPose(const rosbag::MessageInstance& instance) {
  const std::string& topic = instance.getTopic();
  const std::string& type = instance.getDataType();
  if (type == "nav_msgs/Odometry") {
    return FromOdometry(*Instantiate<nav_msgs::Odometry>(instance), topic);
  }
  if (type == "geometry_msgs/PoseStamped") {
    const auto message = Instantiate<geometry_msgs::PoseStamped>(instance);
    return {ToNanoseconds(message->header.stamp), FromPose(message->pose, topic)};
  }
  if (type == "geometry_msgs/PoseWithCovarianceStamped") {
    const auto message = Instantiate<geometry_msgs::PoseWithCovarianceStamped>(instance);
    return {ToNanoseconds(message->header.stamp), FromPose(message->pose.pose, topic)};
  }
  const auto message = Instantiate<geometry_msgs::TransformStamped>(instance);
  geometry_msgs::Pose pose;
  pose.position.x = message->transform.translation.x;
  pose.position.y = message->transform.translation.y;
  pose.position.z = message->transform.translation.z;
  pose.orientation = message->transform.rotation;
  return {ToNanoseconds(message->header.stamp), FromPose(pose, topic)};
}

}  // namespace

Trajectory ReadBagPoses(const BagReader& bag, const std::string& topic) {
  bag.RequireTopic(topic,
                   {"nav_msgs/Odometry",
                    "geometry_msgs/PoseStamped",
                    "geometry_msgs/PoseWithCovarianceStamped",
                    "geometry_msgs/TransformStamped"});
  Trajectory trajectory;
  bag.Read({topic}, [&](const rosbag::MessageInstance& instance) {
    const StampedPose stamped = ReadPose(instance);
    const std::int64_t last_ns = trajectory.empty() ? -1 : trajectory.stamps_ns.back();
    if (stamped.stamp_ns < last_ns) {
      ThrowInputError("{}: topic '{}': stamp {} ns comes after {} ns: expected poses of one run",
                      bag.path().string(),
                      topic,
                      stamped.stamp_ns,
                      last_ns);
    }
    if (stamped.stamp_ns > last_ns) {
      trajectory.stamps_ns.push_back(stamped.stamp_ns);
      trajectory.poses.push_back(stamped.pose);
    }
  });
  if (trajectory.empty()) {
    ThrowInputError("{}: topic '{}' holds no pose", bag.path().string(), topic);
  }
  return trajectory;
}

}  // namespace deja_view
