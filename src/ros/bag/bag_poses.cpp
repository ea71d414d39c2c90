#include "deja_view/ros/bag/bag_poses.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/messages/any_pose.hpp"
#include "deja_view/ros/messages/tf_poses.hpp"

#include <functional>

namespace deja_view {
namespace {

/// Calls use(pose) for each pose of the topic, or of the two frames that stand for it.
void ReadPoses(const BagReader& bag,
               const std::string& topic,
               const std::function<void(const StampedPose&)>& use) {
  const auto frames = ParseTfFrames(topic);
  if (!frames) {
    bag.RequireTopic(topic, PoseMessageTypes());
    bag.Read({topic}, [&](const rosbag::MessageInstance& instance) {
      if (const auto pose = FromAnyPose(instance, topic)) {
        use(*pose);
      }
    });
    return;
  }
  TfPoses tf(*frames);
  bag.RequireTopic(TfPoses::kTopic, {"tf2_msgs/TFMessage", "tf/tfMessage"});
  bag.Read({TfPoses::kTopic, TfPoses::kStaticTopic}, [&](const rosbag::MessageInstance& instance) {
    const auto message = Instantiate<tf2_msgs::TFMessage>(instance);
    if (instance.getTopic() == TfPoses::kStaticTopic) {
      tf.AddStatic(*message);
    } else if (const auto pose = tf.Add(*message)) {
      use(*pose);
    }
  });
}

}  // namespace

Trajectory ReadBagPoses(const BagReader& bag, const std::string& topic) {
  Trajectory trajectory;
  ReadPoses(bag, topic, [&](const StampedPose& stamped) {
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
