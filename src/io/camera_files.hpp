#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <memory>
#include <string>

#include "yaml_section.hpp"

namespace deja_view::internal {

/// What camera files of all layouts tell.
struct CameraFile {
  std::shared_ptr<const Camera> camera;  ///< the first
  Rigid3 T_B_C;                          ///< camera to body (IMU) [m]
  std::string image_topic;               ///< empty: the file has none, as below
  std::string imu_topic;
};

/// The layouts that ReadVinsConfig knows; `root` is the whole file. Focal lengths and sizes are
/// pixels. All throw InputError as YamlSection's getters do.

/// VINS-Mono: camera, `extrinsicRotation` and `extrinsicTranslation` (T_B_C) in one file.
CameraFile ReadVinsMonoFile(const YamlSection& root);

/// VINS-Fusion: `body_T_cam0` is T_B_C; `cam0_calib` names the camera's file, relative to this
/// one's folder.
CameraFile ReadVinsFusionFile(const YamlSection& root);

/// Kalibr's camchain-imucam, also as OpenVINS keeps it: `cam0`'s T_cam_imu is T_C_B, T_imu_cam is
/// T_B_C. Where both stand there, they must agree to 1 mrad and 1 mm.
CameraFile ReadKalibrChain(const YamlSection& root);

/// The ASL format of EuRoC's sensor.yaml, which Kimera keeps: `T_BS` is T_B_C.
CameraFile ReadAslSensor(const YamlSection& root);

/// ORB-SLAM3: `IMU.T_b_c1`, before version 1.0 `Tbc`, is T_B_C.
CameraFile ReadOrbSlamSettings(const YamlSection& root);

}  // namespace deja_view::internal
