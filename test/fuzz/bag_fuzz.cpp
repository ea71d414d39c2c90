// Bags, as check and replay read them.
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"

#include "fuzz.hpp"

namespace deja_view::fuzz {
namespace {

constexpr std::int64_t kStart = 1403636627638560000;

nav_msgs::Odometry Pose(std::int64_t stamp_ns, double x) {
  nav_msgs::Odometry message;
  message.header.stamp = ToRosTime(stamp_ns);
  message.pose.pose = ToPose({Eigen::Quaterniond::Identity(), {x, 0, 0}});
  return message;
}

}  // namespace

std::vector<std::string> Seeds() {
  const VioTopics topics;
  BagWriter bag(Scratch() / "seed.bag");
  for (int i = 0; i < 3; ++i) {
    const std::int64_t stamp = kStart + i * 100'000'000LL;
    bag.Write(topics.image, stamp, ToImage(cv::Mat(6, 8, CV_8UC1, cv::Scalar(i)), stamp, "cam0"));
    bag.Write(topics.extrinsic, stamp, Pose(stamp, 0.1));
    bag.Write(topics.odometry, stamp, Pose(stamp, i));
    bag.Write(topics.keyframe_pose, stamp, Pose(stamp, i));
    sensor_msgs::PointCloud points;
    points.header.stamp = ToRosTime(stamp);
    points.points.resize(2);
    points.channels.resize(2);
    for (auto& channel : points.channels) {
      channel.values = {0, 0, 1, 2, 5};
    }
    bag.Write(topics.keyframe_point, stamp, points);
  }
  bag.Close();
  return {ReadAll(Scratch() / "seed.bag")};
}

void RunOne(const std::string& input) {
  ReplayCallbacks callbacks;
  callbacks.on_keyframe = [](const KeyframeInput&) {};
  callbacks.on_extrinsic = [](const Rigid3&) {};
  callbacks.on_odometry = [](const StampedPose&) {};
  callbacks.on_relative_pose = [](const RelativePoseUpdate&) {};
  callbacks.on_virtual_view = [](const VirtualView&) {};
  ReplayBag(Write("flight.bag", input), VioTopics(), {}, callbacks);
}

}  // namespace deja_view::fuzz
