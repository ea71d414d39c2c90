#include "pose_gradient.hpp"

namespace deja_view::nerf::internal {
namespace {

void AddGrid(const FeatureGrid& grid,
             const GridGradient& gradient,
             std::vector<std::array<float, 3>>* d_position) {
  for (std::size_t l = 0; l < gradient.levels.size(); ++l) {
    const GridLevel& level = grid.levels()[l];
    const auto features = static_cast<std::size_t>(level.features);
    for (std::size_t s = 0; s < gradient.size(); ++s) {
      AddSlopes(level,
                grid.parameters().data() + level.offset,
                {gradient.x[s], gradient.y[s], gradient.z[s]},
                gradient.levels[l].data() + s * features,
                &(*d_position)[s]);
    }
  }
}

}  // namespace

void ComputePoseGradients(const RadianceField& field,
                          const std::vector<Ray>& rays,
                          const Trace& trace,
                          const ChunkGradient& gradient,
                          std::vector<PoseGradient>* poses) {
  std::vector<std::array<float, 3>> d_position(trace.size(), {0, 0, 0});
  AddGrid(field.geometry, gradient.geometry, &d_position);
  AddGrid(field.appearance, gradient.appearance, &d_position);
  poses->assign(rays.size(), PoseGradient{});
  for (std::size_t s = 0; s < trace.size(); ++s) {
    AddToPose(rays[trace.ray[s]], trace.t[s], d_position[s], &(*poses)[trace.ray[s]]);
  }
}

}  // namespace deja_view::nerf::internal
