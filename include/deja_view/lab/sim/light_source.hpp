#pragma once

#include <vector>

#include <Eigen/Core>

namespace deja_view::sim {

/// A lamp or window as the points that light the hall.
struct LightSource {
  std::vector<Eigen::Vector3f> points;                 ///< [m] in W, each with an equal share
  Eigen::Vector3f normal = -Eigen::Vector3f::UnitZ();  ///< shines to this side
  float intensity = 1;
};

}  // namespace deja_view::sim
