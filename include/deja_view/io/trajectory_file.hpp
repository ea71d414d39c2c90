#pragma once

#include "deja_view/geometry/trajectory.hpp"

#include <filesystem>
#include <string>

namespace deja_view {

enum class TrajectoryFormat {
  kTum,     ///< `stamp tx ty tz qx qy qz qw` (ReadTum)
  kCsv,     ///< `stamp_ns, tx, ty, tz, qw, qx, qy, qz, ...`: EuRoC's data.csv, VINS-Mono's
            ///< vins_result_loop.csv and vins_result_no_loop.csv
  kColmap,  ///< a model of COLMAP whose images are named by their stamps
};

struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  Trajectory trajectory;
  bool is_of_camera = false;  ///< COLMAP's poses are the camera's, with an arbitrary scale
};

/// Reads a trajectory from any of the formats, which the content tells apart. A directory is a
/// COLMAP model or a folder in EuRoC's ASL layout (mav0/state_groundtruth_estimate0/data.csv).
/// Throws InputError that names the path, the line and what was expected; for a bag, since a topic
/// has to be named; and for a file without any pose.
TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path);

/// Comma-separated poses: stamp in nanoseconds, position [m], quaternion (w, x, y, z); what follows
/// in a line is passed over, as are lines that begin with #. Throws as ReadTum does.
Trajectory ReadCsvTrajectory(const std::filesystem::path& path);

/// The folder of camera 0's images in a folder of EuRoC's ASL layout (mav0/cam0/data), or
/// `directory` itself where it has no such layout.
std::filesystem::path FindAslImages(const std::filesystem::path& directory);

}  // namespace deja_view
