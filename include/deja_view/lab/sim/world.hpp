#pragma once

#include "deja_view/lab/sim/light_source.hpp"
#include "deja_view/lab/sim/obstacle.hpp"
#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view::sim {

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
