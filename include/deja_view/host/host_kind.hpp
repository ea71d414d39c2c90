#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/host/vio_topics.hpp"

#include <array>
#include <utility>

namespace deja_view {

/// The odometries whose topics are known.
enum class HostKind {
  kVinsMono,
  kVinsFusion,  ///< VINS-Mono's topics; hears of no relocalisation
  kOpenVins,
  kOdometry,  ///< any: poses alone; keyframes and their points are made of the images
};

template <>
struct EnumNames<HostKind> {
  static constexpr std::array<std::pair<HostKind, const char*>, 4> kNames = {
      {{HostKind::kVinsMono, "vins_mono"},
       {HostKind::kVinsFusion, "vins_fusion"},
       {HostKind::kOpenVins, "openvins"},
       {HostKind::kOdometry, "odometry"}}};
};

/// Topics under which the host publishes; those that it does not have are empty.
VioTopics TopicsOf(HostKind host);

}  // namespace deja_view
