#include "deja_view/lab/sim/obstacle.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::sim {

double Obstacle::Distance(const Eigen::Vector3d& p_W) const {
  const Eigen::Vector3d d = p_W - centre;
  Eigen::Vector3d outside;
  if (is_cylinder) {
    const double across = std::hypot(d.x(), d.y()) - half_size.x();
    outside = {across, across, std::abs(d.z()) - half_size.z()};
    outside.y() = std::min(across, 0.0);  // counted once
  } else {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    const Eigen::Vector3d local(c * d.x() + s * d.y(), -s * d.x() + c * d.y(), d.z());
    outside = local.cwiseAbs() - half_size;
  }
  const double beyond = outside.cwiseMax(0.0).norm();
  if (beyond > 0) {
    return beyond;
  }
  return is_cylinder ? std::max(outside.x(), outside.z()) : outside.maxCoeff();
}

}  // namespace deja_view::sim
