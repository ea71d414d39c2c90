#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// A pixel of an image at which COLMAP found a point.
struct ColmapObservation {
  Eigen::Vector2d pixel;  ///< our convention: (0, 0) is the centre of the top left pixel
  std::uint64_t point = 0;
};

struct ColmapImage {
  std::uint32_t id = 0;
  std::uint32_t camera = 0;
  std::string name;                             ///< path below the folder of the images
  Rigid3 T_W_C;                                 ///< camera to world
  std::vector<ColmapObservation> observations;  ///< of points that the model holds
};

struct ColmapPoint {
  Eigen::Vector3d p_W;
  double error_px = 0;    ///< mean reprojection error
  std::size_t track = 0;  ///< how many images saw it
};

/// A sparse model of COLMAP. Its world W has arbitrary scale, origin and orientation; its cameras
/// look right-down-front, as ours do.
struct ColmapModel {
  std::filesystem::path directory;  ///< where the files are
  std::map<std::uint32_t, std::shared_ptr<const Camera>> cameras;
  std::vector<ColmapImage> images;  ///< sorted by name
  std::unordered_map<std::uint64_t, ColmapPoint> points;
};

}  // namespace deja_view
