#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <filesystem>
#include <memory>
#include <string>

namespace deja_view {

/// What the loop closer needs of VINS-Mono's camera/IMU YAML; keys it does not know are VINS-Mono's
/// own and are passed over.
struct VinsConfig {
  std::shared_ptr<const Camera> camera;
  Rigid3 T_B_C;              ///< `extrinsicRotation`, `extrinsicTranslation`
  std::string imu_topic;     ///< optional
  std::string image_topic;   ///< required
  bool loop_closure = true;  ///< optional, as all that follow
  bool fast_relocalization = false;
  bool load_previous_pose_graph = false;
  std::string pose_graph_save_path;    ///< directory; as written, may be relative
  std::string output_path;             ///< directory; as written, may be relative
  double visualize_camera_size = 0.4;  ///< [m]
};

/// Reads a YAML file in VINS-Mono's layout (OpenCV's FileStorage: a `%YAML:1.0` line, matrices as
/// `!!opencv-matrix`). `model_type` PINHOLE, KANNALA_BRANDT or MEI.
///
/// The rotation is projected on SO(3); it may be off by 1e-3 (rounded files).
/// Throws InputError that names file, key, the value found and what was expected: file or key
/// missing, wrong type, not finite, unknown model, impossible size or focal length, no rotation
/// matrix.
VinsConfig ReadVinsConfig(const std::filesystem::path& path);

}  // namespace deja_view
