#include "view_points.hpp"

#include "deja_view/host/keyframe_assembler.hpp"
#include "deja_view/ros/messages/conversions.hpp"

namespace deja_view::internal {

TrackedPoints ReadTrackedPoints(const BagReader& bag,
                                const VioTopics& topics,
                                const Camera& camera,
                                const Rigid3& T_B_C) {
  std::map<std::int64_t, Rigid3> T_C_W;
  TrackedPoints samples;
  if (bag.TypeOf(topics.keyframe_pose) != "nav_msgs/Odometry" ||
      bag.TypeOf(topics.keyframe_point) != "sensor_msgs/PointCloud") {
    return samples;
  }
  const auto read = [&bag](const std::string& topic, const auto& visit) {
    bag.Read({topic}, [&visit](const rosbag::MessageInstance& instance) {
      try {
        visit(instance);
      } catch (const InputError&) {
        // One message less; the loop closer, which needs them all, reports it.
      }
    });
  };
  read(topics.keyframe_pose, [&](const rosbag::MessageInstance& instance) {
    const StampedPose T_W_B =
        FromOdometry(*Instantiate<nav_msgs::Odometry>(instance), instance.getTopic());
    T_C_W[KeyframeAssembler::Key(T_W_B.stamp_ns)] = (T_W_B.pose * T_B_C).Inverse();
  });
  read(topics.keyframe_point, [&](const rosbag::MessageInstance& instance) {
    const auto message = Instantiate<sensor_msgs::PointCloud>(instance);
    const std::int64_t key = KeyframeAssembler::Key(ToNanoseconds(message->header.stamp));
    const auto pose = T_C_W.find(key);
    if (pose == T_C_W.end()) {
      return;
    }
    for (const TrackedPoint& point : FromKeyframePoints(*message, instance.getTopic())) {
      const Eigen::Vector3d p_C = pose->second * point.p_W;
      if (camera.Project(p_C)) {
        samples[key].push_back({point.pixel.cast<double>(), p_C.norm()});
      }
    }
  });
  return samples;
}

}  // namespace deja_view::internal
