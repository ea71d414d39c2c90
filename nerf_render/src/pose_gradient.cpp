#include "pose_gradient.hpp"

#include "grid_corners.hpp"

namespace deja_view::nerf::internal {
namespace {

// Adds to d_position[s] what level by level interpolation passes on from d_level (n x features).
void AddLevel(const GridLevel& level,
              const float* table,
              const GridGradient& gradient,
              const std::vector<float>& d_level,
              std::vector<std::array<float, 3>>* d_position) {
  const auto features = static_cast<std::size_t>(level.features);
  for (std::size_t s = 0; s < gradient.size(); ++s) {
    const Corners corners = FindCorners(level, gradient.x[s], gradient.y[s], gradient.z[s]);
    for (std::uint32_t c = 0; c < 8; ++c) {
      float value = 0;
      for (std::size_t f = 0; f < features; ++f) {
        value += table[corners.entry[c] * features + f] * d_level[s * features + f];
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float slope = (c >> axis & 1U) != 0 ? level.scale : -level.scale;
        for (std::size_t other = 0; other < 3; ++other) {
          if (other != axis) {
            const float fraction = corners.fraction[other];
            slope *= (c >> other & 1U) != 0 ? fraction : 1 - fraction;
          }
        }
        (*d_position)[s][axis] += slope * value;
      }
    }
  }
}

void AddGrid(const FeatureGrid& grid,
             const GridGradient& gradient,
             std::vector<std::array<float, 3>>* d_position) {
  for (std::size_t l = 0; l < gradient.levels.size(); ++l) {
    const GridLevel& level = grid.levels()[l];
    AddLevel(
        level, grid.parameters().data() + level.offset, gradient, gradient.levels[l], d_position);
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
    const Ray& ray = rays[trace.ray[s]];
    PoseGradient& pose = (*poses)[trace.ray[s]];
    // p = origin + t direction: a rotation w moves it by w x (t direction).
    const std::array<float, 3>& g = d_position[s];
    const std::array<float, 3>& d = ray.direction;
    const float t = trace.t[s];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t next = (axis + 1) % 3;
      const std::size_t last = (axis + 2) % 3;
      pose[axis] += g[axis];
      pose[3 + axis] += t * (d[next] * g[last] - d[last] * g[next]);
    }
  }
}

}  // namespace deja_view::nerf::internal
