#include "deja_view/lab/sim/camera_yaml.hpp"

#include <fmt/format.h>

namespace deja_view::sim {

std::string CameraYaml(const PinholeParameters& camera, const Rigid3& T_B_C) {
  const Eigen::Matrix3d R = T_B_C.R();
  std::string text = fmt::format(
      "%YAML:1.0\n"
      "imu_topic: \"/imu0\"\n"
      "image_topic: \"/cam0/image_raw\"\n"
      "output_path: \"output/\"\n"
      "model_type: PINHOLE\n"
      "camera_name: camera\n"
      "image_width: {}\n"
      "image_height: {}\n"
      "distortion_parameters:\n"
      "   k1: {:.9e}\n   k2: {:.9e}\n   p1: {:.9e}\n   p2: {:.9e}\n"
      "projection_parameters:\n"
      "   fx: {:.9e}\n   fy: {:.9e}\n   cx: {:.9e}\n   cy: {:.9e}\n",
      camera.width,
      camera.height,
      camera.k1,
      camera.k2,
      camera.p1,
      camera.p2,
      camera.fx,
      camera.fy,
      camera.cx,
      camera.cy);
  const auto matrix = [&](const char* key, int columns, const std::string& data) {
    text += fmt::format("{}: !!opencv-matrix\n   rows: 3\n   cols: {}\n   dt: d\n   data: [{}]\n",
                        key,
                        columns,
                        data);
  };
  std::string rotation;
  for (int i = 0; i < 9; ++i) {
    rotation += fmt::format("{}{:.15f}", i > 0 ? ", " : "", R(i / 3, i % 3));
  }
  matrix("extrinsicRotation", 3, rotation);
  matrix("extrinsicTranslation",
         1,
         fmt::format("{:.9f}, {:.9f}, {:.9f}", T_B_C.t.x(), T_B_C.t.y(), T_B_C.t.z()));
  text +=
      "loop_closure: 1\n"
      "load_previous_pose_graph: 0\n"
      "fast_relocalization: 0\n"
      "pose_graph_save_path: \"output/pose_graph/\"\n"
      "visualize_camera_size: 0.4\n";
  return text;
}

}  // namespace deja_view::sim
