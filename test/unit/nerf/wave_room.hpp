#pragma once

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/nerf/options.hpp"
#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "viewed_scene.hpp"

namespace deja_view::nerf {

constexpr double kHalfRoom = 1.5;  ///< [m] half the room's side

// Along a ray, to the walls of a cubic room that is seen from within.
inline double WallRange(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double t = std::numeric_limits<double>::max();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double wall = direction[axis] > 0 ? kHalfRoom : -kHalfRoom;
    if (std::abs(direction[axis]) > 1e-9) {
      t = std::min(t, (wall - origin[axis]) / direction[axis]);
    }
  }
  return t;
}

// Smooth waves on the walls.
inline float WallRadiance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d p = origin + WallRange(origin, direction) * direction;
  return static_cast<float>(0.5 + 0.2 * std::sin(4 * p.x() + p.y()) +
                            0.2 * std::cos(5 * p.y() - 3 * p.z()));
}

inline TrainingView MakeView(const std::shared_ptr<const Camera>& camera,
                             const Rigid3& T_N_C,
                             float gain) {
  return ViewOf(camera, T_N_C, [&](const Eigen::Vector3d& ray) {
    return 255 * (gain * WallRadiance(T_N_C.t, ray)) + 0.5F;
  });
}

// Where the wall is at a pixel.
inline DepthPoint WallPoint(const TrainingView& view, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = view.T_N_C.q * view.camera->Unproject(pixel);
  return {static_cast<float>(pixel.x()),
          static_cast<float>(pixel.y()),
          static_cast<float>(WallRange(view.T_N_C.t, ray))};
}

inline std::shared_ptr<const Camera> SmallCamera() {
  PinholeParameters parameters;
  parameters.width = 48;
  parameters.height = 36;
  parameters.fx = parameters.fy = 30;
  parameters.cx = 23.5;
  parameters.cy = 17.5;
  parameters.k1 = -0.05;
  return std::make_shared<PinholeCamera>(parameters);
}

inline Rigid3 Pose(int i) {
  const double u = 0.35 * i;
  return {ExpSo3({0.3 * std::sin(u), u, 0.2 * std::cos(u)}),
          {0.6 * std::sin(1.7 * u), 0.4 * std::cos(2.3 * u), 0.6 * std::cos(1.1 * u)}};
}

inline std::vector<TrainingView> MakeViews(int count) {
  const std::shared_ptr<const Camera> camera = SmallCamera();
  std::vector<TrainingView> views;
  for (int i = 0; i < count; ++i) {
    views.push_back(MakeView(camera, Pose(i), i % 2 == 0 ? 0.9F : 1.0F));
    views.back().name = std::to_string(i);
  }
  return views;
}

inline SceneBox RoomBox() {
  SceneBox box;
  box.min.setConstant(-1.6);
  box.max.setConstant(1.6);
  return box;
}

inline TrainOptions SmallOptions() {
  TrainOptions options;
  options.field.geometry = {4, 2, 14, 8, 32};
  options.field.appearance = {3, 4, 14, 8, 32};
  options.field.color_hidden = 16;
  options.field.occupancy_resolution = 32;
  options.march.min_step = 1.0F / 128;
  options.march.max_step = 1.0F / 128;
  options.target_samples = 1 << 14;
  options.max_rays = 2048;
  options.warmup_steps = 60;
  return options;
}

}  // namespace deja_view::nerf
