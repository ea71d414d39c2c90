#include "deja_view/ros/bag/odometry_topic.hpp"

#include "deja_view/ros/messages/any_pose.hpp"

namespace deja_view {
namespace {

template <typename Message>
WaitingImage Waiting(const Message& message, ImageSource source) {
  return {ToNanoseconds(message.header.stamp), std::move(source), message.data.size()};
}

}  // namespace

OdometryTopic::OdometryTopic(const BagReader& bag, const std::string& topic) : topic_(topic) {
  const auto frames = ParseTfFrames(topic);
  if (!frames) {
    bag.RequireTopic(topic, PoseMessageTypes());
    names_ = {topic};
    return;
  }
  const std::vector<std::string> types = {"tf2_msgs/TFMessage", "tf/tfMessage"};
  tf_.emplace(*frames);
  bag.RequireTopic(TfPoses::kTopic, types);
  names_ = {TfPoses::kTopic};
  if (bag.HasTopic(TfPoses::kStaticTopic)) {
    bag.RequireTopic(TfPoses::kStaticTopic, types);
    names_.emplace_back(TfPoses::kStaticTopic);
  }
}

std::optional<StampedPose> OdometryTopic::Read(const rosbag::MessageInstance& instance) {
  if (!tf_) {
    return FromAnyPose(instance, topic_);
  }
  const auto message = Instantiate<tf2_msgs::TFMessage>(instance);
  if (instance.getTopic() == TfPoses::kStaticTopic) {
    tf_->AddStatic(*message);
    return std::nullopt;
  }
  return tf_->Add(*message);
}

std::optional<std::string> OdometryTopic::Missing() const {
  return tf_ && !tf_->has_pose() ? std::optional(tf_->Describe()) : std::nullopt;
}

void RequireImages(const BagReader& bag, const std::string& topic) {
  bag.RequireTopic(topic, {"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
}

WaitingImage ReadImage(const rosbag::MessageInstance& instance, cv::Size size) {
  if (instance.getDataType() == "sensor_msgs/CompressedImage") {
    const auto message = Instantiate<sensor_msgs::CompressedImage>(instance);
    return Waiting(*message, FromCompressedImage(message, instance.getTopic(), size));
  }
  const auto message = Instantiate<sensor_msgs::Image>(instance);
  return Waiting(*message, FromImage(message, instance.getTopic(), size));
}

}  // namespace deja_view
