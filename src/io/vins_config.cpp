#include "deja_view/io/vins_config.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "camera_files.hpp"

namespace deja_view {
namespace {

bool HasAny(const internal::YamlSection& root, std::initializer_list<const char*> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return root.Has(key); });
}

VinsConfig ToConfig(internal::CameraFile file) {
  VinsConfig config;
  config.camera = std::move(file.camera);
  config.T_B_C = file.T_B_C;
  config.image_topic = std::move(file.image_topic);
  config.imu_topic = std::move(file.imu_topic);
  return config;
}

// The settings of both VINS.
VinsConfig WithSettings(const internal::YamlSection& root, internal::CameraFile file) {
  VinsConfig config = ToConfig(std::move(file));
  config.loop_closure = root.GetFlagOr("loop_closure", true);
  config.fast_relocalization = root.GetFlagOr("fast_relocalization", false);
  config.load_previous_pose_graph = root.GetFlagOr("load_previous_pose_graph", false);
  config.pose_graph_save_path = root.GetOr<std::string>("pose_graph_save_path", "a directory", "");
  config.output_path = root.GetOr<std::string>("output_path", "a directory", "");
  config.visualize_camera_size = root.GetOr<double>("visualize_camera_size", "a number", 0.4);
  return config;
}

// What a user may add to a layout without it.
VinsConfig WithAddedTopics(const internal::YamlSection& root, internal::CameraFile file) {
  constexpr const char* kExpected = "a topic name";
  VinsConfig config = ToConfig(std::move(file));
  config.image_topic = root.GetOr<std::string>("image_topic", kExpected, config.image_topic);
  config.imu_topic = root.GetOr<std::string>("imu_topic", kExpected, config.imu_topic);
  return config;
}

}  // namespace

VinsConfig ReadVinsConfig(const std::filesystem::path& path) {
  const internal::YamlSection root(path, internal::LoadYamlMap(path), "");
  // VINS-Mono's first, with what only VINS-Mono's has; last what is left of it without its model.
  if (root.Has("model_type")) {
    return WithSettings(root, internal::ReadVinsMonoFile(root));
  }
  if (HasAny(root, {"cam0_calib", "body_T_cam0"})) {
    return WithSettings(root, internal::ReadVinsFusionFile(root));
  }
  if (root.Has("cam0")) {
    return WithAddedTopics(root, internal::ReadKalibrChain(root));
  }
  if (root.Has("T_BS")) {
    return WithAddedTopics(root, internal::ReadAslSensor(root));
  }
  if (HasAny(root, {"Camera.type", "Camera1.fx", "Camera.fx"})) {
    return WithAddedTopics(root, internal::ReadOrbSlamSettings(root));
  }
  if (HasAny(root, {"extrinsicRotation", "extrinsicTranslation", "projection_parameters"})) {
    return WithSettings(root, internal::ReadVinsMonoFile(root));
  }
  ThrowInputError(
      "{}: no known camera file: expected VINS-Mono's (model_type), VINS-Fusion's (cam0_calib), "
      "Kalibr's or OpenVINS' camera chain (cam0), EuRoC's sensor.yaml or Kimera's camera (T_BS), "
      "or ORB-SLAM3's settings (Camera.type)",
      path.string());
}

std::string RequireImageTopic(const VinsConfig& config,
                              const std::filesystem::path& path,
                              const std::string& given) {
  const std::string& topic = given.empty() ? config.image_topic : given;
  if (topic.empty()) {
    ThrowInputError(
        "{}: key 'image_topic' is missing: expected the topic of the camera's images, here or "
        "as a parameter",
        path.string());
  }
  return topic;
}

}  // namespace deja_view
