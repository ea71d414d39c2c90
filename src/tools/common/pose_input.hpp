#pragma once

#include "deja_view/geometry/trajectory_alignment.hpp"

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

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

/// As above, of "FILE", "BAG:/topic", or "/topic" of `bag`, which is empty where there is none.
PoseSource ReadFlightPoses(const std::string& file_or_topic,
                           const std::filesystem::path& bag,
                           bool is_of_camera);

/// `pairs, inlier_share, rmse_m, max_m, rotation_deg, scale`.
nlohmann::ordered_json ToJson(const RobustAlignment& alignment);

}  // namespace deja_view
