#pragma once

#include "deja_view/views/scene_cells.hpp"

#include <vector>

#include <Eigen/Core>

namespace deja_view::nerf {

/// Cuts space into `count` cells of about as many cameras each: again and again across the axis
/// along which the cameras are spread most. The order of the cameras does not matter. Throws
/// InputError when they stand at too few places for that, and for positions that are not finite.
std::vector<SceneCell> CutByCameras(const std::vector<Eigen::Vector3d>& positions_N, int count);

}  // namespace deja_view::nerf
