#pragma once

#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/view_flight.hpp"

namespace deja_view::internal {

/// The tracked points of a bag's keyframes. Messages that can't be used are passed over, as are
/// points behind the camera; a bag without the topics gives none.
TrackedPoints ReadTrackedPoints(const BagReader& bag,
                                const VioTopics& topics,
                                const Camera& camera,
                                const Rigid3& T_B_C);

}  // namespace deja_view::internal
