#pragma once

#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"

#include <string>

namespace deja_view {

/// The poses of a topic by the stamps of their headers: nav_msgs/Odometry,
/// geometry_msgs/PoseStamped, PoseWithCovarianceStamped or TransformStamped (Vicon), or of
/// "tf:WORLD,BODY". A stamp that
/// comes twice counts once. Throws InputError that names the topic for another type, a pose that is
/// none, stamps that go back, and a topic without any message.
Trajectory ReadBagPoses(const BagReader& bag, const std::string& topic);

}  // namespace deja_view
