#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// An image of a bag.
struct BagImage {
  std::int64_t stamp_ns = 0;  ///< of its header
  /// Reads the message again and decodes it: CV_8UC1, or CV_8UC3 (blue, green, red) where it has
  /// colours. Safe to call from several threads; throws InputError that names the topic. Holds the
  /// bag open.
  std::function<cv::Mat()> read;
};

/// The images of a topic (sensor_msgs/Image or CompressedImage), in order of their stamps; a stamp
/// that comes twice counts once. Throws InputError for a bag that lacks the topic or can't be read.
std::vector<BagImage> ListBagImages(const std::shared_ptr<const BagReader>& bag,
                                    const std::string& topic);

/// A keyframe of VINS-Mono with the points that it tracked.
struct BagKeyframe {
  std::int64_t stamp_ns = 0;
  Rigid3 T_W_C;  ///< with the VIO's own calibration of that time
  std::vector<TrackedPoint> points;
};

/// Keyframes whose pose and points have the same stamp, in order of recording. Throws InputError
/// for a bag without the keyframe_pose, keyframe_point or extrinsic topic, or without any pose of
/// the camera.
std::vector<BagKeyframe> ReadBagKeyframes(const BagReader& bag, const VioTopics& topics);

}  // namespace deja_view
