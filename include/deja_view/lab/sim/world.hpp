#pragma once

#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view::sim {

/// A lamp or window as the points that light the hall.
struct LightSource {
  std::vector<Eigen::Vector3f> points;                 ///< [m] in W, each with an equal share
  Eigen::Vector3f normal = -Eigen::Vector3f::UnitZ();  ///< shines to this side
  float intensity = 1;
};

/// Furniture as the flight planner sees it: an upright box or cylinder.
struct Obstacle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();     ///< [m] in W
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();  ///< [m]; a cylinder's radius in x and y
  double yaw = 0;                                       ///< [rad]
  bool is_cylinder = false;

  /// Distance [m] of p_W to the surface; negative inside (then a lower bound of the depth).
  double Distance(const Eigen::Vector3d& p_W) const;
};

/// A textured hall, the same for the same seed and options. An elliptic lane around the middle is
/// kept free of all but low furniture, so that there is a way for every flight. Immutable.
class World {
 public:
  /// Throws CheckError when the options are not valid.
  World(std::uint64_t seed, const WorldOptions& options, int threads = 0);

  const WorldOptions& options() const { return options_; }
  const Scene& scene() const { return scene_; }
  const std::vector<Obstacle>& obstacles() const { return obstacles_; }
  const std::vector<LightSource>& lamps() const { return lamps_; }

  Eigen::Vector3d size() const { return {options_.length_m, options_.width_m, options_.height_m}; }
  Eigen::Vector3d centre() const { return 0.5 * size(); }

  /// Distance [m] of p_W to the nearest wall or obstacle; negative inside one or outside of the
  /// hall.
  double Clearance(const Eigen::Vector3d& p_W) const;

 private:
  WorldOptions options_;
  Scene scene_;
  std::vector<Obstacle> obstacles_;
  std::vector<LightSource> lamps_;
};

}  // namespace deja_view::sim
