#include "deja_view/ros/bag/bag_images.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <iterator>
#include <map>
#include <mutex>
#include <utility>

#include <nav_msgs/Odometry.h>
#include <ros/exception.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud.h>

namespace deja_view {
namespace {

cv::Mat DecodeMessage(const rosbag::MessageInstance& instance) {
  if (instance.getDataType() == "sensor_msgs/Image") {
    return FromImage(Instantiate<sensor_msgs::Image>(instance),
                     instance.getTopic(),
                     cv::Size(),
                     PixelKind::kColor)();
  }
  return FromCompressedImage(Instantiate<sensor_msgs::CompressedImage>(instance),
                             instance.getTopic(),
                             cv::Size(),
                             PixelKind::kColor)();
}

std::int64_t ReadStamp(const rosbag::MessageInstance& instance) {
  return ToNanoseconds(instance.getDataType() == "sensor_msgs/Image"
                           ? Instantiate<sensor_msgs::Image>(instance)->header.stamp
                           : Instantiate<sensor_msgs::CompressedImage>(instance)->header.stamp);
}

}  // namespace

std::vector<BagImage> ListBagImages(const std::shared_ptr<const BagReader>& bag,
                                    const std::string& topic) {
  bag->RequireTopic(topic, {"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
  // A bag is read by one thread at a time.
  const auto mutex = std::make_shared<std::mutex>();
  std::map<std::int64_t, BagImage> images;
  bag->Read({topic}, [&](const rosbag::MessageInstance& instance) {
    BagImage image;
    image.stamp_ns = ReadStamp(instance);
    image.read = [bag, mutex, instance] {
      const std::lock_guard<std::mutex> lock(*mutex);
      try {
        return DecodeMessage(instance);
      } catch (const ros::Exception& e) {
        ThrowInputError("{}: topic '{}': can't be read: {}",
                        bag->path().string(),
                        instance.getTopic(),
                        e.what());
      }
    };
    images.emplace(image.stamp_ns, std::move(image));
  });
  if (images.empty()) {
    ThrowInputError("{}: topic '{}' holds no image", bag->path().string(), topic);
  }
  std::vector<BagImage> sorted;
  for (auto& [stamp_ns, image] : images) {
    sorted.push_back(std::move(image));
  }
  return sorted;
}

std::vector<BagKeyframe> ReadBagKeyframes(const BagReader& bag, const VioTopics& topics) {
  for (const std::string& topic : {topics.keyframe_pose, topics.extrinsic}) {
    bag.RequireTopic(topic, {"nav_msgs/Odometry"});
  }
  bag.RequireTopic(topics.keyframe_point, {"sensor_msgs/PointCloud"});
  std::map<std::int64_t, Rigid3> T_W_B;
  std::map<std::int64_t, Rigid3> T_B_C;
  std::vector<BagKeyframe> keyframes;
  bag.Read({topics.keyframe_pose, topics.keyframe_point, topics.extrinsic},
           [&](const rosbag::MessageInstance& instance) {
             const std::string& topic = instance.getTopic();
             if (topic == topics.keyframe_point) {
               const auto message = Instantiate<sensor_msgs::PointCloud>(instance);
               keyframes.push_back(
                   {ToNanoseconds(message->header.stamp), {}, FromKeyframePoints(*message, topic)});
               return;
             }
             const StampedPose stamped =
                 FromOdometry(*Instantiate<nav_msgs::Odometry>(instance), topic);
             (topic == topics.keyframe_pose ? T_W_B : T_B_C)[stamped.stamp_ns] = stamped.pose;
           });
  std::vector<BagKeyframe> complete;
  for (BagKeyframe& keyframe : keyframes) {
    const auto pose = T_W_B.find(keyframe.stamp_ns);
    const auto later = T_B_C.upper_bound(keyframe.stamp_ns);
    if (pose == T_W_B.end() || T_B_C.empty()) {
      continue;
    }
    keyframe.T_W_C =
        pose->second * (later == T_B_C.begin() ? later->second : std::prev(later)->second);
    complete.push_back(std::move(keyframe));
  }
  if (complete.empty()) {
    ThrowInputError("{}: no keyframe has a pose, points and an extrinsic", bag.path().string());
  }
  return complete;
}

}  // namespace deja_view
