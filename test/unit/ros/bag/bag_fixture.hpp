#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "temporary_directory.hpp"
#include <gtest/gtest.h>

namespace deja_view {

/// A directory of its own for each test, and small bags in VINS-Mono's topics.
class BagTest : public TemporaryDirectoryTest {
 protected:
  static constexpr std::int64_t kMillisecond = 1000000;
  static constexpr std::int64_t kStart = 1403636627638560000;

  std::filesystem::path Path(const std::string& name) const { return directory_ / name; }

  static std::string ErrorOf(const std::function<void()>& body) {
    return MessageOf<InputError>(body);
  }

  static sensor_msgs::Image MakeImage(std::int64_t stamp_ns, std::uint8_t grey) {
    return ToImage(cv::Mat(48, 64, CV_8UC1, cv::Scalar(grey)), stamp_ns, "cam0");
  }

  static nav_msgs::Odometry MakeOdometry(std::int64_t stamp_ns, double x) {
    nav_msgs::Odometry message;
    message.header.stamp = ToRosTime(stamp_ns);
    message.header.frame_id = "world";
    message.pose.pose = ToPose({Eigen::Quaterniond::Identity(), {x, 0, 0}});
    return message;
  }

  static sensor_msgs::PointCloud MakePoints(std::int64_t stamp_ns, int count) {
    sensor_msgs::PointCloud message;
    message.header.stamp = ToRosTime(stamp_ns);
    message.points.resize(static_cast<std::size_t>(count));
    message.channels.resize(message.points.size());
    for (auto& channel : message.channels) {
      channel.values = {0, 0, 10, 20, 5};
    }
    return message;
  }

  /// `keyframes` keyframes 100 ms apart at x = 0, 1, 2...; pose and points 200 ms after the image.
  std::filesystem::path WriteFlight(const std::string& name, int keyframes) const {
    const VioTopics topics;
    BagWriter bag(Path(name));
    for (int i = 0; i < keyframes; ++i) {
      const std::int64_t stamp = kStart + i * 100 * kMillisecond;
      bag.Write(topics.image, stamp, MakeImage(stamp, static_cast<std::uint8_t>(i)));
      const std::int64_t later = stamp + 200 * kMillisecond;
      bag.Write(topics.extrinsic,
                later - 100 * kMillisecond,
                MakeOdometry(stamp, i < keyframes / 2 ? 0.25 : 0.28));
      bag.Write(topics.odometry, later, MakeOdometry(stamp, i));
      bag.Write(topics.keyframe_pose, later, MakeOdometry(stamp, i));
      bag.Write(topics.keyframe_point, later, MakePoints(stamp, i));
    }
    bag.Close();
    return Path(name);
  }
};

}  // namespace deja_view
