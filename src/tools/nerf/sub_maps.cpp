#include "nerf/sub_maps.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <utility>

namespace deja_view {

SceneCells CutScene(const nerf::Split& split, const std::string& shard) {
  SceneCells cells;
  if (shard.empty()) {
    return cells;
  }
  const Shard own = ParseShard("--shard", shard);
  if (own.count > 1) {
    std::vector<Eigen::Vector3d> positions;
    for (const auto* images : {&split.training, &split.held_out, &split.depth_checks}) {
      for (const nerf::PosedImage& image : *images) {
        positions.push_back(image.T_N_C.t);
      }
    }
    cells.index = own.index;
    cells.cells = nerf::CutByCameras(positions, own.count);
  }
  return cells;
}

void CheckShard(const std::string& shard, const SceneCells& cells, const std::string& model) {
  const Shard own = cells.shard();
  if (!shard.empty() && ParseShard("--shard", shard) != own) {
    ThrowInputError("--shard {}: {} is the model of {}/{}: leave --shard out",
                    shard,
                    model,
                    own.index,
                    own.count);
  }
}

void KeepOwnImages(const SceneCells& cells, nerf::Split* split) {
  nerf::Split own;
  for (std::size_t i = 0; i < split->held_out.size(); ++i) {
    if (cells.IsOwn(split->held_out[i].T_N_C.t)) {
      own.held_out.push_back(std::move(split->held_out[i]));
      own.next.push_back(split->next[i]);
    }
  }
  if (own.held_out.empty()) {
    ThrowInputError("none of the {} held-out images is of sub-map {}/{}",
                    split->held_out.size(),
                    cells.index,
                    cells.cells.size());
  }
  split->held_out = std::move(own.held_out);
  split->next = std::move(own.next);
  auto& checks = split->depth_checks;
  checks.erase(
      std::remove_if(checks.begin(),
                     checks.end(),
                     [&](const nerf::PosedImage& image) { return !cells.IsOwn(image.T_N_C.t); }),
      checks.end());
}

}  // namespace deja_view
