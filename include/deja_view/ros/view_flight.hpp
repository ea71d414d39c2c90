#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/ros/bag_replay.hpp"
#include "deja_view/ros/bag_writer.hpp"
#include "deja_view/views/depth_warp_renderer.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// When an image was taken and when it was recorded.
struct RecordedImage {
  std::int64_t stamp_ns = 0;
  std::int64_t recorded_ns = 0;
};

/// A grey image with the frame of its header.
struct DecodedImage {
  cv::Mat image;
  std::string frame_id;
};

/// The VIO's tracked points of each keyframe as pixels with ranges, by the key of its stamp
/// (KeyframeAssembler::Key).
using TrackedPoints = std::map<std::int64_t, std::vector<RangeSample>>;

/// What virtual views are rendered for, as messages in the order of recording: a bag, or a folder
/// of images. All calls throw InputError that names the file or topic and what was expected.
class ViewFlight {
 public:
  virtual ~ViewFlight() = default;

  /// For errors.
  virtual const std::filesystem::path& path() const = 0;
  virtual bool HasTopic(const std::string& topic) const = 0;
  /// Topics, types and numbers of messages, a line each; tells flights apart.
  virtual std::string Describe() const = 0;
  /// Looks for what would otherwise come out only in ReadAll, after hours of rendering.
  virtual void CheckContent(int threads) const = 0;

  /// All images of a topic.
  virtual std::vector<RecordedImage> ListImages(const std::string& topic) const = 0;
  /// Decodes the images that were recorded at the given times and hands over one after the other.
  virtual void ReadImages(
      const std::string& topic,
      const std::set<std::int64_t>& recorded_ns,
      const std::function<void(std::int64_t recorded_ns, const DecodedImage&)>& visit) const = 0;
  /// The stamps of the VIO's keyframes.
  virtual std::vector<std::int64_t> KeyframeStamps(const VioTopics& topics) const = 0;
  /// Empty where there are none.
  virtual TrackedPoints ReadTrackedPoints(const VioTopics& topics,
                                          const Camera& camera,
                                          const Rigid3& T_B_C) const = 0;

  /// Hands over the time of each message, and what writes it to a bag.
  using WriteMessage = std::function<void(BagWriter* bag)>;
  virtual void ReadAll(const std::function<void(std::int64_t recorded_ns,
                                                const WriteMessage& write)>& visit) const = 0;
};

/// The messages of a bag, byte for byte.
std::shared_ptr<const ViewFlight> OpenBagFlight(const std::filesystem::path& bag);

/// The images of a folder (ListStampedImages) as sensor_msgs/Image on `topic`, mono8 or bgr8,
/// recorded at their stamps, of the camera's size.
std::shared_ptr<const ViewFlight> OpenImageFlight(const std::filesystem::path& directory,
                                                  const std::string& topic,
                                                  std::shared_ptr<const Camera> camera);

}  // namespace deja_view
