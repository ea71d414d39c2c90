#pragma once

#include "deja_view/front_end/odometry_front_end.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/host/keyframe_assembler.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/host/vio_topics.hpp"
#include "deja_view/ros/messages/conversions.hpp"
#include "deja_view/views/virtual_view.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace deja_view {

class BagReader;

/// What a replay hands over. Empty callbacks are passed over, and their topics are not read.
struct ReplayCallbacks {
  /// Required. An InputError that it throws is counted and passed to on_problem; the replay goes
  /// on.
  std::function<void(const KeyframeInput&)> on_keyframe;
  /// Just before the first keyframe for which the VIO's camera calibration holds.
  std::function<void(const Rigid3& T_B_C)> on_extrinsic;
  std::function<void(const StampedPose& T_W_B)> on_odometry;
  std::function<void(const RelativePoseUpdate&)> on_relative_pose;
  /// In the order of the bag, which may be before or after its keyframe. As on_keyframe, it may
  /// throw InputError.
  std::function<void(const VirtualView&)> on_virtual_view;
  std::string sufficient_features;  ///< as FromVirtualFrame's
  cv::Size image_size;              ///< as FromImage's
  /// A message that can't be used, with the reason, or a keyframe that was dropped.
  std::function<void(const std::string& what)> on_problem;
  /// After each message: how many of all messages are done.
  std::function<void(std::int64_t done, std::int64_t total)> on_progress;
};

struct ReplayReport {
  AssemblerCounts assembler;
  FrontEndCounts front_end;       ///< where keyframes were made of images and poses
  std::int64_t messages = 0;      ///< read from the bag
  std::int64_t bad_messages = 0;  ///< messages and keyframes that could not be used
};

/// Throws InputError for a bag without virtual views, save one that tells by its settings
/// (ViewTopics) that none could be made.
void RequireVirtualViews(const BagReader& bag, const std::string& frame_topic);

/// Reads a bag of VINS-Mono's topics and images (sensor_msgs/Image or CompressedImage) at full
/// speed, and hands over its keyframes exactly as the node assembles them from the same topics.
/// Throws InputError for a bag that can't be read, or that lacks the image, keyframe_pose or
/// keyframe_point topic.
ReplayReport ReplayBag(const std::filesystem::path& bag,
                       const VioTopics& topics,
                       const KeyframeAssemblerOptions& options,
                       const ReplayCallbacks& callbacks);

/// The same with the virtual views of another bag in place of the first one's; they are not read
/// without `callbacks.on_virtual_view`. With `front_end`, keyframes are made of the images and the
/// poses of `topics.odometry` (nav_msgs/Odometry, geometry_msgs/PoseStamped,
/// PoseWithCovarianceStamped or TransformStamped, or "tf:WORLD,BODY"), and only these are read;
/// with `T_W_B`, of the images and these poses. Throws UnusableFlight for poses whose world is not
/// level where it ought to be.
ReplayReport ReplayBag(const std::filesystem::path& bag,
                       const std::filesystem::path& virtual_bag,
                       const VioTopics& topics,
                       const KeyframeAssemblerOptions& options,
                       const ReplayCallbacks& callbacks,
                       const std::optional<FrontEndSetup>& front_end = std::nullopt,
                       const Trajectory& T_W_B = {});

}  // namespace deja_view
