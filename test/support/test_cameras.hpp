#pragma once

#include "deja_view/camera/pinhole_camera.hpp"

#include <memory>

namespace deja_view {

/// A pinhole without distortion; all in pixels.
inline PinholeCamera PinholeOf(int width, int height, double focal, double cx, double cy) {
  return PinholeCamera({width, height, focal, focal, cx, cy, 0, 0, 0, 0});
}

inline std::shared_ptr<const PinholeCamera> SharedPinholeOf(
    int width, int height, double focal, double cx, double cy) {
  return std::make_shared<PinholeCamera>(PinholeOf(width, height, focal, cx, cy));
}

/// A small one with a lens that bends.
inline const std::shared_ptr<const PinholeCamera>& BentCamera() {
  static const auto camera = std::make_shared<const PinholeCamera>(
      PinholeParameters{320, 240, 200, 200, 159.5, 119.5, -0.1, 0.01, 0, 0});
  return camera;
}

}  // namespace deja_view
