#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/host/vio_topics.hpp"
#include "deja_view/host/world_level.hpp"

#include <string>

namespace deja_view {

/// The odometries whose topics are known.
enum class HostKind {
  kVinsMono,
  kVinsFusion,  ///< VINS-Mono's topics; hears of no relocalisation
  kOpenVins,
  kOdometry,  ///< any: poses alone; keyframes and their points are made of the images
};

template <>
inline constexpr auto kEnumNames<HostKind> =
    EnumNames("vins_mono", "vins_fusion", "openvins", "odometry");

/// Topics under which the host publishes; those that it does not have are empty.
VioTopics TopicsOf(HostKind host);

/// Throws InputError that names the `option` where gravity is to be estimated of a host with an
/// IMU: its world is level, and its keyframes are its own.
void CheckGravity(HostKind host, GravityPolicy gravity, const std::string& option);

}  // namespace deja_view
