#pragma once

#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/io/colmap_model.hpp"

#include <filesystem>

namespace deja_view {

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
