#pragma once

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/view_bag.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <tuple>

#include "bag_fixture.hpp"
#include "room_renderer.hpp"
#include <opencv2/imgcodecs.hpp>

namespace deja_view {

/// A message as it lies in a bag.
struct RawMessage {
  std::int64_t time_ns = 0;
  std::string topic;
  std::string md5;
  std::string bytes;

  bool operator==(const RawMessage& o) const {
    return time_ns == o.time_ns && topic == o.topic && md5 == o.md5 && bytes == o.bytes;
  }
};

/// A flight through a room whose appearance is known, and a job that renders its views.
class ViewBagTest : public BagTest {
 protected:
  static constexpr int kImages = 6;

  ViewBagTest() {
    job_.flight = OpenBagFlight(WriteRoomFlight("flight.bag"));
    job_.out = Path("out.bag");
    job_.camera = camera_;
    job_.options.sampling.views = 2;
    job_.options.sampling.radius_m = 0.5;
    job_.options.sampling.min_radius_m = 0.2;
    job_.options.sampling.spacing_max_m = 1;
    job_.options.fit_scale = 0.5;
    job_.settings = "room\n";
    for (int i = 0; i < kImages; ++i) {
      job_.T_N_C.stamps_ns.push_back(Stamp(i));
      job_.T_N_C.poses.push_back(Pose(i));
    }
  }

  static std::int64_t Stamp(int i) { return kStart + i * 100 * kMillisecond; }
  static Rigid3 Pose(int i) { return {ExpSo3({0.1, 0.2, 0}), {-1 + 0.4 * i, 0.1 * i, 0}}; }

  // Images 3 ms late, of which every other one is a keyframe, and other topics.
  std::filesystem::path WriteRoomFlight(const std::string& name) {
    const VioTopics topics;
    BagWriter bag(Path(name));
    for (int i = 0; i < kImages; ++i) {
      const std::int64_t time = Stamp(i) + 3 * kMillisecond;
      bag.Write("/imu0", time - 1, MakeOdometry(time - 1, i));
      const cv::Mat image = RoomRenderer().Render(*camera_, Pose(i), {0.9F, 0.05F, 1}).image;
      bag.Write(topics.image, time, ToImage(image, Stamp(i), "cam0"));
      bag.Write("/imu0", time + kMillisecond, MakeOdometry(time, i));
      if (i % 2 == 0) {
        nav_msgs::Odometry pose = MakeOdometry(Stamp(i), 0);
        pose.pose.pose = ToPose(Pose(i));
        bag.Write(topics.keyframe_pose, time + 150 * kMillisecond, pose);
        sensor_msgs::PointCloud points = MakePoints(Stamp(i), 1);
        const Eigen::Vector3d p_W = Pose(i) * Eigen::Vector3d(0, 0, 1.5);
        points.points[0].x = static_cast<float>(p_W.x());
        points.points[0].y = static_cast<float>(p_W.y());
        points.points[0].z = static_cast<float>(p_W.z());
        bag.Write(topics.keyframe_point, time + 150 * kMillisecond, points);
      }
    }
    bag.Close();
    return Path(name);
  }

  // The same images as files.
  void WriteRoomImages(const std::string& folder) {
    std::filesystem::create_directories(Path(folder));
    for (int i = 0; i < kImages; ++i) {
      const cv::Mat image = RoomRenderer().Render(*camera_, Pose(i), {0.9F, 0.05F, 1}).image;
      cv::imwrite(Path(folder) / (std::to_string(Stamp(i)) + ".png"), image);
    }
  }

  ViewReport Run(const ViewJob& job) {
    return RenderViews(
        job, RoomFactory(), [this](ViewStep step, std::size_t done, std::size_t total) {
          if (step == ViewStep::kRendering && done >= interrupt_at_) {
            throw std::runtime_error("interrupted");
          }
          EXPECT_LE(done, total);
        });
  }

  ViewRendererFactory RoomFactory() {
    return [this](const ViewSource&, const std::vector<RangeSample>& points) {
      ++rendered_;
      points_.insert(points_.end(), points.begin(), points.end());
      return std::make_shared<RoomRenderer>();
    };
  }

  static std::vector<RawMessage> ReadMessages(const std::filesystem::path& path, bool is_virtual) {
    std::vector<RawMessage> messages;
    BagReader(path).ReadAll([&](const rosbag::MessageInstance& m) {
      if ((m.getTopic().find("/virtual") == 0) == is_virtual) {
        std::string bytes(m.size(), '\0');
        ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()), m.size());
        m.write(stream);
        messages.push_back({ToNanoseconds(m.getTime()), m.getTopic(), m.getMD5Sum(), bytes});
      }
    });
    // A bag has no order among messages of the same time.
    std::sort(messages.begin(), messages.end(), [](const RawMessage& a, const RawMessage& b) {
      return std::tie(a.time_ns, a.topic) < std::tie(b.time_ns, b.topic);
    });
    return messages;
  }

  static std::string Bytes(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }

  std::shared_ptr<const Camera> camera_ = std::make_shared<PinholeCamera>(
      PinholeParameters{160, 120, 100, 100, 79.5, 59.5, -0.1, 0.01, 0, 0});
  ViewJob job_;
  std::size_t interrupt_at_ = 1000;
  int rendered_ = 0;
  std::vector<RangeSample> points_;
};

}  // namespace deja_view
