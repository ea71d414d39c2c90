#include "deja_view/camera/camera_parameters.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "camera_files.hpp"

namespace deja_view::internal {
namespace {

// What a pinhole's lens may have.
std::vector<double> ReadRadtan(const YamlSection& root, const std::string& prefix) {
  const std::vector<std::string> keys = {
      prefix + "k1", prefix + "k2", prefix + "p1", prefix + "p2"};
  const bool has_any =
      std::any_of(keys.begin(), keys.end(), [&](const std::string& key) { return root.Has(key); });
  const std::vector<double> radtan =
      has_any ? root.GetFinites(keys) : std::vector<double>(keys.size(), 0.0);
  const std::string k3 = prefix + "k3";
  if (root.Has(k3) && root.GetFinite(k3) != 0) {
    root.Fail(k3, "0, or a calibration with k1, k2, p1 and p2 alone");
  }
  return radtan;
}

std::shared_ptr<const Camera> ReadOrbSlamCamera(const YamlSection& root) {
  constexpr const char* kTypes = "PinHole, KannalaBrandt8 or Rectified";
  // Before version 1.0 the first camera had no number.
  const bool is_old = root.Has("Camera.fx") && !root.Has("Camera1.fx");
  const std::string prefix = is_old ? "Camera." : "Camera1.";
  const auto type = root.Get<std::string>("Camera.type", kTypes);
  const bool is_fisheye = type == "KannalaBrandt8";
  if (!is_fisheye && type != "PinHole" && type != "Rectified") {
    root.Fail("Camera.type", kTypes);
  }
  CameraParameters camera;
  camera.model = is_fisheye ? "KANNALA_BRANDT" : "PINHOLE";
  camera.width = root.GetSize("Camera.width");
  camera.height = root.GetSize("Camera.height");
  camera.projection = {root.GetPositive(prefix + "fx"),
                       root.GetPositive(prefix + "fy"),
                       root.GetFinite(prefix + "cx"),
                       root.GetFinite(prefix + "cy")};
  if (is_fisheye) {
    camera.distortion =
        root.GetFinites({prefix + "k1", prefix + "k2", prefix + "k3", prefix + "k4"});
  } else {
    camera.distortion =
        type == "Rectified" ? std::vector<double>(4, 0.0) : ReadRadtan(root, prefix);
  }
  return MakeCamera(camera, root.path().string());
}

}  // namespace

CameraFile ReadOrbSlamSettings(const YamlSection& root) {
  CameraFile file;
  file.camera = ReadOrbSlamCamera(root);
  const bool is_old = root.Has("Tbc") && !root.Has("IMU.T_b_c1");
  file.T_B_C = root.GetTransform(is_old ? "Tbc" : "IMU.T_b_c1");
  return file;
}

}  // namespace deja_view::internal
