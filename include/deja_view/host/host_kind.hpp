#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/host/vio_topics.hpp"

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

}  // namespace deja_view
