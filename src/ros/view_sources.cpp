#include "deja_view/ros/view_sources.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "view_points.hpp"

namespace deja_view {
namespace {

std::int64_t StampOf(const rosbag::MessageInstance& instance) {
  if (instance.isType<sensor_msgs::Image>()) {
    return ToNanoseconds(Instantiate<sensor_msgs::Image>(instance)->header.stamp);
  }
  return ToNanoseconds(Instantiate<sensor_msgs::CompressedImage>(instance)->header.stamp);
}

// Keys (KeyframeAssembler::Key) of the keyframes' stamps; nothing when all images are wanted.
std::optional<std::set<std::int64_t>> KeyframeKeys(const BagReader& bag,
                                                   const VioTopics& topics,
                                                   SourceKind kind) {
  if (kind == SourceKind::kImages ||
      (kind == SourceKind::kAuto && !bag.HasTopic(topics.keyframe_pose))) {
    return std::nullopt;
  }
  bag.RequireTopic(topics.keyframe_pose, {"nav_msgs/Odometry"});
  std::set<std::int64_t> keys;
  bag.Read({topics.keyframe_pose}, [&keys](const rosbag::MessageInstance& instance) {
    keys.insert(KeyframeAssembler::Key(
        ToNanoseconds(Instantiate<nav_msgs::Odometry>(instance)->header.stamp)));
  });
  return keys;
}

struct DecodedImage {
  cv::Mat image;
  std::string frame_id;
};

DecodedImage Decode(const rosbag::MessageInstance& instance) {
  const std::string topic = instance.getTopic();
  if (instance.isType<sensor_msgs::Image>()) {
    const auto message = Instantiate<sensor_msgs::Image>(instance);
    return {FromImage(message, topic)(), message->header.frame_id};
  }
  const auto message = Instantiate<sensor_msgs::CompressedImage>(instance);
  return {FromCompressedImage(message, topic)(), message->header.frame_id};
}

void CheckSize(const cv::Mat& image, const Camera& camera, const std::string& topic) {
  if (image.cols != camera.width() || image.rows != camera.height()) {
    ThrowInputError("{}: image of {} x {} px: expected the camera's {} x {}",
                    topic,
                    image.cols,
                    image.rows,
                    camera.width(),
                    camera.height());
  }
}

}  // namespace

SourceImages FindSourceImages(const BagReader& bag,
                              const VioTopics& topics,
                              SourceKind kind,
                              const Trajectory& T_N_C,
                              std::int64_t max_gap_ns) {
  bag.RequireTopic(topics.image, {"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
  const std::optional<std::set<std::int64_t>> keyframes = KeyframeKeys(bag, topics, kind);
  SourceImages result;
  std::set<std::int64_t> seen;
  bag.Read({topics.image}, [&](const rosbag::MessageInstance& instance) {
    const std::int64_t stamp_ns = StampOf(instance);
    const bool is_wanted = !keyframes || keyframes->count(KeyframeAssembler::Key(stamp_ns)) > 0;
    if (!is_wanted || !seen.insert(stamp_ns).second) {
      return;
    }
    if (const std::optional<Rigid3> pose = T_N_C.At(stamp_ns, max_gap_ns)) {
      result.images.push_back({stamp_ns, ToNanoseconds(instance.getTime()), *pose});
    } else {
      ++result.without_pose;
    }
  });
  if (result.images.empty()) {
    ThrowInputError("{}: none of the {} images on '{}' has a pose: expected poses at their stamps",
                    bag.path().string(),
                    result.without_pose,
                    topics.image);
  }
  return result;
}

std::vector<SourceImage> SelectSourceImages(const std::vector<SourceImage>& images,
                                            const SourceOptions& options) {
  std::vector<Rigid3> poses;
  poses.reserve(images.size());
  for (const SourceImage& image : images) {
    poses.push_back(image.T_N_C);
  }
  std::vector<SourceImage> selected;
  for (const std::size_t i : SelectSources(poses, options)) {
    selected.push_back(images[i]);
  }
  return selected;
}

std::vector<SourceImage> SourceImagesAt(const std::vector<SourceImage>& images,
                                        const std::vector<std::int64_t>& stamps_ns) {
  std::set<std::int64_t> keys;
  for (const std::int64_t stamp_ns : stamps_ns) {
    keys.insert(KeyframeAssembler::Key(stamp_ns));
  }
  std::vector<SourceImage> found;
  std::copy_if(images.begin(), images.end(), std::back_inserter(found), [&](const SourceImage& i) {
    return keys.count(KeyframeAssembler::Key(i.stamp_ns)) > 0;
  });
  if (found.empty()) {
    ThrowInputError("none of the {} images with a pose has one of the {} stamps asked for",
                    images.size(),
                    stamps_ns.size());
  }
  return found;
}

void ReadSourceImages(const BagReader& bag,
                      const VioTopics& topics,
                      const Camera& camera,
                      const Rigid3& T_B_C,
                      const std::vector<SourceImage>& images,
                      const std::function<void(const LoadedSource&)>& visit) {
  std::map<std::int64_t, SourceImage> wanted;  // by the time of recording
  for (const SourceImage& image : images) {
    wanted[image.recorded_ns] = image;
  }
  if (wanted.empty()) {
    return;
  }
  const auto points = internal::ReadTrackedPoints(bag, topics, camera, T_B_C);
  bag.Read({topics.image}, [&](const rosbag::MessageInstance& instance) {
    const auto image = wanted.find(ToNanoseconds(instance.getTime()));
    if (image == wanted.end()) {
      return;
    }
    const DecodedImage decoded = Decode(instance);
    CheckSize(decoded.image, camera, topics.image);
    LoadedSource loaded;
    loaded.source = {image->second.stamp_ns, decoded.image, image->second.T_N_C};
    loaded.recorded_ns = image->second.recorded_ns;
    loaded.frame_id = decoded.frame_id;
    const auto found = points.find(KeyframeAssembler::Key(loaded.source.stamp_ns));
    loaded.points = found == points.end() ? std::vector<RangeSample>() : found->second;
    wanted.erase(image);
    visit(loaded);
  });
}

}  // namespace deja_view
