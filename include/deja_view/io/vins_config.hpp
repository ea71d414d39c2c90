#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <filesystem>
#include <memory>
#include <string>

namespace deja_view {

/// What the loop closer needs of a camera file; named after VINS-Mono's, in which all of it can
/// stand. Keys that are not known are the odometry's own and are passed over.
struct VinsConfig {
  std::shared_ptr<const Camera> camera;
  Rigid3 T_B_C;              ///< camera to body (IMU) [m]
  std::string imu_topic;     ///< optional
  std::string image_topic;   ///< empty where the file names none: see RequireImageTopic
  bool loop_closure = true;  ///< optional and of both VINS, as all that follow
  bool fast_relocalization = false;
  bool load_previous_pose_graph = false;
  std::string pose_graph_save_path;    ///< directory; as written, may be relative
  std::string output_path;             ///< directory; as written, may be relative
  double visualize_camera_size = 0.4;  ///< [m]
};

/// Reads the camera file of an odometry as it is; the layout is told by its keys:
///   `model_type`                VINS-Mono: PINHOLE, KANNALA_BRANDT or MEI
///   `cam0_calib`                VINS-Fusion, with the camera's own file beside it
///   `cam0`                      Kalibr's and OpenVINS' camera chain
///   `T_BS`                      EuRoC's sensor.yaml, Kimera's camera
///   `Camera.type`, `Camera1.fx` ORB-SLAM3's settings
/// Of several cameras the first is read. OpenCV's first line `%YAML:1.0` may stand there. What is
/// read of each layout: doc/files.md.
///
/// The rotation is projected on SO(3); it may be off by 1e-3 (rounded files).
/// Throws InputError that names file, key, the value found and what was expected: no known layout,
/// file or key missing, wrong type, wrong count of numbers, not finite, unknown camera or
/// distortion model, impossible size or focal length, no rotation matrix.
VinsConfig ReadVinsConfig(const std::filesystem::path& path);

/// The topic of the images: `given` unless empty, else the file's. Throws InputError that names the
/// file, `path`, when there is neither: ORB-SLAM3, EuRoC and Kimera name none, but an `image_topic`
/// may be added to their files, and does not disturb them.
std::string RequireImageTopic(const VinsConfig& config,
                              const std::filesystem::path& path,
                              const std::string& given = "");

}  // namespace deja_view
