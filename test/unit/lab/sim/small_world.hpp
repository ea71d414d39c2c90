#pragma once

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/world.hpp"

#include <memory>

namespace deja_view::sim {

/// A small hall with coarse textures, made in a moment.
inline SimOptions TinyOptions() {
  SimOptions options = MakePreset("small");
  options.camera.scale = 0.25;
  options.flight.duration_s = 6.0;
  options.world.texture_size_px = 128;
  options.world.light_spacing_m = 0.5;
  options.threads = 1;
  return options;
}

/// The hall of TinyOptions with seed 1, made once per test program.
inline std::shared_ptr<const World> TinyWorld() {
  static const auto world = std::make_shared<const World>(1, TinyOptions().world, 1);
  return world;
}

inline std::shared_ptr<const PinholeCamera> TinyCamera() {
  return std::make_shared<PinholeCamera>(SimulatedCamera(TinyOptions().camera));
}

/// A camera in the middle of the hall at 1.5 m, looking along `yaw` [rad] and a little down.
inline Rigid3 LookAlong(const World& world, double yaw) {
  Eigen::Matrix3d R_F_C;
  R_F_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Rigid3 T_W_C{FromYaw(yaw) * Eigen::Quaterniond(R_F_C) * ExpSo3({-0.15, 0, 0}), world.centre()};
  T_W_C.t += Eigen::Vector3d(0.55 * world.centre().x(), 0, 0);
  T_W_C.t.z() = 1.5;
  return T_W_C;
}

}  // namespace deja_view::sim
