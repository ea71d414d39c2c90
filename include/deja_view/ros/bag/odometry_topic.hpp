#pragma once

#include "deja_view/host/image_source.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/messages/tf_poses.hpp"

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/types.hpp>

namespace deja_view {

/// An odometry's poses in a bag: of a topic of one of PoseMessageTypes(), or of "tf:WORLD,BODY".
class OdometryTopic {
 public:
  /// Throws InputError for a bag that lacks the topic or has it of another type.
  OdometryTopic(const BagReader& bag, const std::string& topic);

  /// What is to be read of the bag.
  const std::vector<std::string>& names() const { return names_; }

  /// The pose that a message of these gives, if any. Throws InputError for a bad one.
  std::optional<StampedPose> Read(const rosbag::MessageInstance& instance);

  /// Why there is no pose of tf; nothing where there is one, and of a topic.
  std::optional<std::string> Missing() const;

 private:
  std::string topic_;
  std::vector<std::string> names_;
  std::optional<TfPoses> tf_;
};

/// Throws InputError for a bag that lacks the topic of images or has it of another type.
void RequireImages(const BagReader& bag, const std::string& topic);

/// A sensor_msgs/Image or CompressedImage by the stamp of its header, still to be decoded. Throws
/// InputError as FromImage and FromCompressedImage do.
WaitingImage ReadImage(const rosbag::MessageInstance& instance, cv::Size size);

}  // namespace deja_view
