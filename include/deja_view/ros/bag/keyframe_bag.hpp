#pragma once

#include "deja_view/front_end/odometry_front_end.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace deja_view {

/// Keyframes of a bag's images and poses, to be written in VINS-Mono's topics.
struct KeyframeBagJob {
  std::filesystem::path bag;  ///< with images and poses
  std::filesystem::path out;  ///< the bag to write
  std::string image_topic;
  std::string odometry_topic;      ///< as OdometryTopic's
  std::string second_image_topic;  ///< of front_end.second, if there is one
  FrontEndSetup front_end;
  std::function<void(const std::string& what)> on_problem;  ///< with a message that can't be used
  std::function<void(std::int64_t done, std::int64_t total)> on_progress;  ///< messages
};

/// Makes keyframes of the images and poses, as a node or a replay with host odometry does, and
/// writes what VINS-Mono would: the images as they are, /vins_estimator/odometry of every pose, and
/// /vins_estimator/{keyframe_pose, keyframe_point, extrinsic} of every keyframe, recorded at the
/// time of the message that completed it. Throws InputError for a bag that can't be read or written
/// or that lacks a topic, and UnusableFlight as OdometryFrontEnd.
FrontEndCounts WriteKeyframeBag(const KeyframeBagJob& job);

}  // namespace deja_view
