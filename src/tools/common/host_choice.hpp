#pragma once

#include "deja_view/front_end/odometry_front_end.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/host/host_kind.hpp"
#include "deja_view/io/vins_config.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace deja_view {

/// Whose topics a bag has.
struct HostChoice {
  HostKind host = HostKind::kVinsMono;
  std::string odometry_topic;  ///< empty: the host's
  GravityPolicy gravity = GravityPolicy::kGiven;
  std::string poses;  ///< ReadFlightPoses, in place of the odometry's; empty: the topic's
  std::string poses_of = "body";  ///< or camera

  /// With the image topic of the camera file. Throws InputError when it names none.
  VioTopics Topics(const VinsConfig& vins, const std::filesystem::path& camera) const;
  /// How keyframes are made of images and poses, for a host that gives no others, and where poses
  /// are given. Throws InputError for a gravity that is to be estimated for another one.
  std::optional<FrontEndSetup> FrontEnd(const VinsConfig& vins,
                                        const OdometryFrontEndOptions& options) const;
  /// T_W_B of `poses` in metres: those of COLMAP are brought to the host's in the bag. Empty where
  /// none are given. Throws InputError.
  Trajectory Poses(const VinsConfig& vins, const std::filesystem::path& bag) const;
};

/// --host, --odometry-topic and --gravity. Keeps a reference to `choice`.
void AddHostOptions(CLI::App* sub, HostChoice* choice);

/// --poses and --poses-of. Keeps a reference to `choice`.
void AddHostPosesOptions(CLI::App* sub, HostChoice* choice);

}  // namespace deja_view
