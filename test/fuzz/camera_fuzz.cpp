// Camera files of all odometries; after a first byte of 1, the second file of VINS-Fusion's two.
#include "deja_view/io/vins_config.hpp"

#include "fuzz.hpp"

namespace deja_view::fuzz {
namespace {

const char* const kMatrix =
    ": !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n"
    "   data: [0, 0, 1, 0.1,  -1, 0, 0, 0.2,  0, -1, 0, 0.3,  0, 0, 0, 1]\n";
const char* const kRows =
    "  - [0, -1, 0, 0.2]\n  - [0, 0, -1, 0.3]\n  - [1, 0, 0, -0.1]\n  - [0, 0, 0, 1]\n";

std::string FusionFile() {
  return std::string(
             "%YAML:1.0\nnum_of_cam: 1\nimage0_topic: \"/cam0\"\ncam0_calib: second.yaml\n") +
         "body_T_cam0" + kMatrix;
}

std::string FusionCamera() {
  return "%YAML:1.0\nmodel_type: MEI\nimage_width: 640\nimage_height: 480\n"
         "mirror_parameters:\n   xi: 1.5\ndistortion_parameters:\n   k1: 0.1\n   k2: 0.01\n"
         "   p1: 0\n   p2: 0\nprojection_parameters:\n   gamma1: 400\n   gamma2: 410\n   u0: 320\n"
         "   v0: 240\n";
}

}  // namespace

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (const char* shipped : {"euroc.yaml", "openvins.yaml"}) {
    const std::filesystem::path path = std::filesystem::path(DEJA_VIEW_SOURCE_CONFIG) / shipped;
    if (std::filesystem::exists(path)) {
      seeds.push_back('\0' + ReadAll(path));
    }
  }
  seeds.push_back('\0' + FusionFile());
  seeds.push_back('\1' + FusionCamera());
  seeds.push_back('\0' + std::string("cam0:\n  T_cam_imu:\n") + kRows +
                  "  camera_model: pinhole\n  distortion_model: equidistant\n"
                  "  distortion_coeffs: [0.1, 0.01, 0.001, 0.0001]\n"
                  "  intrinsics: [400, 410, 320, 240]\n  resolution: [640, 480]\n"
                  "  rostopic: /cam0\n");
  seeds.push_back('\0' +
                  std::string("T_BS:\n  rows: 4\n  cols: 4\n  data: [0, 0, 1, 0.1, -1, 0, 0, "
                              "0.2, 0, -1, 0, 0.3, 0, 0, 0, 1]\nresolution: [640, 480]\n"
                              "camera_model: pinhole\nintrinsics: [400, 410, 320, 240]\n"
                              "distortion_model: radial-tangential\n"
                              "distortion_coefficients: [0.1, 0.01, 0, 0]\n"));
  seeds.push_back('\0' +
                  std::string("%YAML:1.0\nCamera.type: \"KannalaBrandt8\"\nCamera1.fx: 400\n"
                              "Camera1.fy: 410\nCamera1.cx: 320\nCamera1.cy: 240\n"
                              "Camera1.k1: 0.1\nCamera1.k2: 0\nCamera1.k3: 0\nCamera1.k4: 0\n"
                              "Camera.width: 640\nCamera.height: 480\nIMU.T_b_c1") +
                  kMatrix);
  return seeds;
}

void RunOne(const std::string& input) {
  const auto [prefix, text] = SplitPrefix(input);
  const bool is_second = prefix == 1;
  Write("second.yaml", is_second ? text : FusionCamera());
  const VinsConfig config = ReadVinsConfig(Write("first.yaml", is_second ? FusionFile() : text));
  config.camera->Project({0.1, 0.2, 1});
}

}  // namespace deja_view::fuzz
