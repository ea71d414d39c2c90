#pragma once

#include "deja_view/ros/bag_reader.hpp"
#include "deja_view/ros/bag_replay.hpp"
#include "deja_view/views/depth_warp_renderer.hpp"

#include <cstdint>
#include <map>
#include <vector>

namespace deja_view::internal {

/// The VIO's tracked points of each keyframe as pixels with ranges, by the key of its stamp
/// (KeyframeAssembler::Key). Messages that can't be used are passed over, as are points behind the
/// camera; a bag without the topics gives none.
std::map<std::int64_t, std::vector<RangeSample>> ReadTrackedPoints(const BagReader& bag,
                                                                   const VioTopics& topics,
                                                                   const Camera& camera,
                                                                   const Rigid3& T_B_C);

}  // namespace deja_view::internal
