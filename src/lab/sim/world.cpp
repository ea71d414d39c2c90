#include "deja_view/lab/sim/world.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/sim/light.hpp"

#include <algorithm>

#include "world_builder.hpp"

namespace deja_view::sim {

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
