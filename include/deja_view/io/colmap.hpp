#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/geometry/trajectory.hpp"

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

/// True when `directory`, or its `sparse/0`, `sparse` or `0`, holds a model's files.
bool IsColmapModel(const std::filesystem::path& directory);

/// Reads cameras, images and points3D, `.bin` or `.txt`, from `directory` or the folders below it
/// that IsColmapModel knows. SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV,
/// SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE and OPENCV_FISHEYE become our cameras; principal points
/// and pixels move by half a pixel, since COLMAP's (0, 0) is the top left pixel's corner.
/// Throws InputError that names the file, and the line or record, for a file that is missing, cut
/// off or malformed, another camera model, an image without its camera, numbers that are not
/// finite, and quaternions whose norm is off by more than 1e-2.
ColmapModel ReadColmapModel(const std::filesystem::path& directory);

/// Writes cameras.txt, images.txt and points3D.txt, each whole or not at all: what ReadColmapModel
/// reads. Every observation's point must be in `model.points`; tracks are those of the
/// observations. Throws InputError for a camera that COLMAP has no model for (MEI), and where a
/// file can't be written.
void WriteColmapModel(const ColmapModel& model, const std::filesystem::path& directory);

/// The cameras' poses T_W_C by the stamps that the images' names say (ParseImageStamp). Throws
/// InputError that names an image whose name says none, or two with the same stamp.
Trajectory ToTrajectory(const ColmapModel& model);

}  // namespace deja_view
