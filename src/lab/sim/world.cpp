#include "deja_view/lab/sim/world.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/sim/light.hpp"

#include <algorithm>
#include <cmath>

#include "world_builder.hpp"

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

World::World(std::uint64_t seed, const WorldOptions& options, int threads) : options_(options) {
  SimOptions all;
  all.world = options;
  const auto violations = all.Validate();
  DEJA_VIEW_CHECK_OP(violations.size(), ==, 0U);
  WorldBuilder builder(seed, options, threads);
  builder.Build(&scene_, &obstacles_, &lamps_);
  BakeLight(lamps_, options.light_spacing_m, threads, &scene_);
}

double World::Clearance(const Eigen::Vector3d& p_W) const {
  double clearance = std::min(p_W.minCoeff(), (size() - p_W).minCoeff());
  for (const Obstacle& obstacle : obstacles_) {
    clearance = std::min(clearance, obstacle.Distance(p_W));
  }
  return clearance;
}

}  // namespace deja_view::sim
