#include "deja_view/ros/bag/bag_poses.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/bag/odometry_topic.hpp"

namespace deja_view {

Trajectory ReadBagPoses(const BagReader& bag, const std::string& topic) {
  Trajectory trajectory;
  OdometryTopic odometry(bag, topic);
  bag.Read(odometry.names(), [&](const rosbag::MessageInstance& instance) {
    const auto read = odometry.Read(instance);
    if (!read) {
      return;
    }
    const StampedPose& stamped = *read;
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
