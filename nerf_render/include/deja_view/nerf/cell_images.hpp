#pragma once

#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/nerf/scene_cells.hpp"

#include <vector>

namespace deja_view::nerf {

/// Which images from beside a cell its field learns from.
struct CellImageOptions {
  double room = 0.05;      ///< about the cell's cameras; times the diagonal of all cameras' box
  double min_share = 0.5;  ///< of an image's rays that enter this space
};

/// The images of the cell's own cameras, and those that help them: taken within the space about
/// these cameras, or looking into it far enough that an image's points (their median; none: without
/// end) do not hide it. In order.
std::vector<PosedImage> SelectCellImages(const std::vector<PosedImage>& images,
                                         const SceneCell& cell,
                                         const CellImageOptions& options = {});

}  // namespace deja_view::nerf
