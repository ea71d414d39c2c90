#pragma once

#include "deja_view/geometry/trajectory.hpp"

#include <filesystem>
#include <string>

namespace deja_view {

struct PoseSource {
  Trajectory trajectory;
  bool is_of_camera = false;
  bool has_scale = true;  ///< false: structure from motion, whose scale is arbitrary
};

/// Poses of a file that ReadTrajectoryFile knows, or of `topic` in a bag. `is_of_camera` is what
/// the user says; a COLMAP model is always of the camera. Throws InputError.
PoseSource ReadPoses(const std::filesystem::path& path,
                     const std::string& topic,
                     bool is_of_camera);

/// As above, of "FILE" or "BAG:/topic".
PoseSource ReadPoses(const std::string& file_or_topic, bool is_of_camera);

}  // namespace deja_view
