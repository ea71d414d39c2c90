#pragma once

#include <Eigen/Core>

namespace deja_view::sim {

/// Furniture as the flight planner sees it: an upright box or cylinder.
struct Obstacle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();     ///< [m] in W
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();  ///< [m]; a cylinder's radius in x and y
  double yaw = 0;                                       ///< [rad]
  bool is_cylinder = false;

  /// Distance [m] of p_W to the surface; negative inside (then a lower bound of the depth).
  double Distance(const Eigen::Vector3d& p_W) const;
};

}  // namespace deja_view::sim
