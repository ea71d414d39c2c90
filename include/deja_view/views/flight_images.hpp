#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/vio_topics.hpp"
#include "deja_view/views/depth_warp_renderer.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
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

/// The images of a flight, wherever they are kept. All calls throw InputError that names the file
/// or topic and what was expected.
class FlightImages {
 public:
  virtual ~FlightImages() = default;

  /// For errors.
  virtual const std::filesystem::path& path() const = 0;
  virtual bool HasTopic(const std::string& topic) const = 0;
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
};

}  // namespace deja_view
