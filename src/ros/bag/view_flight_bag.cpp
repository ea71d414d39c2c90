#include "deja_view/base/check.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/view_flight.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include "view_points.hpp"

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

namespace deja_view {
namespace {

std::int64_t StampOf(const rosbag::MessageInstance& instance) {
  if (instance.isType<sensor_msgs::Image>()) {
    return ToNanoseconds(Instantiate<sensor_msgs::Image>(instance)->header.stamp);
  }
  return ToNanoseconds(Instantiate<sensor_msgs::CompressedImage>(instance)->header.stamp);
}

DecodedImage Decode(const rosbag::MessageInstance& instance) {
  const std::string topic = instance.getTopic();
  if (instance.isType<sensor_msgs::Image>()) {
    const auto message = Instantiate<sensor_msgs::Image>(instance);
    return {FromImage(message, topic)(), message->header.frame_id};
  }
  const auto message = Instantiate<sensor_msgs::CompressedImage>(instance);
  return {FromCompressedImage(message, topic)(), message->header.frame_id};
}

class BagFlight final : public ViewFlight {
 public:
  explicit BagFlight(const std::filesystem::path& path) : bag_(path) {}

  const std::filesystem::path& path() const override { return bag_.path(); }
  bool HasTopic(const std::string& topic) const override { return bag_.HasTopic(topic); }

  std::string Describe() const override {
    std::string text;
    for (const BagReader::Topic& topic : bag_.topics()) {
      text += fmt::format("{} {} {}\n", topic.name, topic.type, topic.messages);
    }
    return text;
  }

  // The bag's structure was checked when it was opened.
  void CheckContent(int /*threads*/) const override {}

  std::vector<RecordedImage> ListImages(const std::string& topic) const override {
    bag_.RequireTopic(topic, {"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
    std::vector<RecordedImage> images;
    bag_.Read({topic}, [&images](const rosbag::MessageInstance& instance) {
      images.push_back({StampOf(instance), ToNanoseconds(instance.getTime())});
    });
    return images;
  }

  void ReadImages(
      const std::string& topic,
      const std::set<std::int64_t>& recorded_ns,
      const std::function<void(std::int64_t, const DecodedImage&)>& visit) const override {
    std::set<std::int64_t> wanted = recorded_ns;
    bag_.Read({topic}, [&](const rosbag::MessageInstance& instance) {
      const std::int64_t time_ns = ToNanoseconds(instance.getTime());
      if (wanted.erase(time_ns) > 0) {
        visit(time_ns, Decode(instance));
      }
    });
  }

  std::vector<std::int64_t> KeyframeStamps(const VioTopics& topics) const override {
    bag_.RequireTopic(topics.keyframe_pose, {"nav_msgs/Odometry"});
    std::vector<std::int64_t> stamps;
    bag_.Read({topics.keyframe_pose}, [&stamps](const rosbag::MessageInstance& instance) {
      stamps.push_back(ToNanoseconds(Instantiate<nav_msgs::Odometry>(instance)->header.stamp));
    });
    return stamps;
  }

  TrackedPoints ReadTrackedPoints(const VioTopics& topics,
                                  const Camera& camera,
                                  const Rigid3& T_B_C) const override {
    return internal::ReadTrackedPoints(bag_, topics, camera, T_B_C);
  }

  void ReadAll(const std::function<void(std::int64_t, const WriteMessage&)>& visit) const override {
    bag_.ReadAll([&visit](const rosbag::MessageInstance& instance) {
      visit(ToNanoseconds(instance.getTime()),
            [&instance](BagWriter* out) { out->Copy(instance); });
    });
  }

 private:
  BagReader bag_;
};

}  // namespace

std::shared_ptr<const ViewFlight> OpenBagFlight(const std::filesystem::path& bag) {
  return std::make_shared<BagFlight>(bag);
}

}  // namespace deja_view
