#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view::nerf {

/// A pixel whose distance is known, e.g. a tracked point of a VIO or a pixel of a depth map.
struct DepthPoint {
  float u = 0;      ///< [px]
  float v = 0;      ///< [px]
  float range = 0;  ///< [m] along the unit ray
};

/// A posed image.
struct TrainingView {
  std::string name;
  std::int64_t stamp_ns = 0;  ///< 0: unknown
  cv::Mat image;              ///< CV_8UC1 or CV_8UC3, of the camera's size
  std::shared_ptr<const Camera> camera;
  Rigid3 T_N_C;
  std::vector<DepthPoint> points;
};

}  // namespace deja_view::nerf
