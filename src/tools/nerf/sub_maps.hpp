#pragma once

#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/nerf/scene_cells.hpp"

#include <string>

namespace deja_view {

/// The cells that a scene is cut into for `--shard i/n` (empty: it is not cut), by the cameras of
/// all its images, held out or not. Throws InputError.
SceneCells CutScene(const nerf::Split& split, const std::string& shard);

/// Throws InputError when `shard`, unless it is empty, is not that of the model.
void CheckShard(const std::string& shard, const SceneCells& cells, const std::string& model);

/// Leaves only the held-out images and depth checks of the sub-map. Throws InputError when it has
/// none.
void KeepOwnImages(const SceneCells& cells, nerf::Split* split);

}  // namespace deja_view
