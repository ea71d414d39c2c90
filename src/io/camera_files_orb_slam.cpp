#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <string>

#include "camera_files.hpp"

namespace deja_view::internal {
namespace {

constexpr const char* kWidth = "Camera.width";
constexpr const char* kHeight = "Camera.height";

std::shared_ptr<const Camera> ReadPinhole(const YamlSection& root,
                                          const std::string& prefix,
                                          bool is_rectified) {
  PinholeParameters p;
  p.width = root.GetSize(kWidth);
  p.height = root.GetSize(kHeight);
  p.fx = root.GetPositive(prefix + "fx");
  p.fy = root.GetPositive(prefix + "fy");
  p.cx = root.GetFinite(prefix + "cx");
  p.cy = root.GetFinite(prefix + "cy");
  const bool has_distortion = root.Has(prefix + "k1") || root.Has(prefix + "k2") ||
                              root.Has(prefix + "p1") || root.Has(prefix + "p2");
  if (!is_rectified && has_distortion) {
    p.k1 = root.GetFinite(prefix + "k1");
    p.k2 = root.GetFinite(prefix + "k2");
    p.p1 = root.GetFinite(prefix + "p1");
    p.p2 = root.GetFinite(prefix + "p2");
  }
  const std::string k3 = prefix + "k3";
  if (!is_rectified && root.Has(k3) && root.GetFinite(k3) != 0) {
    root.Fail(k3, "0, or a calibration with k1, k2, p1 and p2 alone");
  }
  return std::make_shared<PinholeCamera>(p);
}

std::shared_ptr<const Camera> ReadKannalaBrandt(const YamlSection& root,
                                                const std::string& prefix) {
  KannalaBrandtParameters p;
  p.width = root.GetSize(kWidth);
  p.height = root.GetSize(kHeight);
  p.mu = root.GetPositive(prefix + "fx");
  p.mv = root.GetPositive(prefix + "fy");
  p.u0 = root.GetFinite(prefix + "cx");
  p.v0 = root.GetFinite(prefix + "cy");
  p.k2 = root.GetFinite(prefix + "k1");
  p.k3 = root.GetFinite(prefix + "k2");
  p.k4 = root.GetFinite(prefix + "k3");
  p.k5 = root.GetFinite(prefix + "k4");
  return std::make_shared<KannalaBrandtCamera>(p);
}

std::shared_ptr<const Camera> ReadOrbSlamCamera(const YamlSection& root) {
  constexpr const char* kTypes = "PinHole, KannalaBrandt8 or Rectified";
  // Before version 1.0 the first camera had no number.
  const bool is_old = root.Has("Camera.fx") && !root.Has("Camera1.fx");
  const std::string prefix = is_old ? "Camera." : "Camera1.";
  const auto type = root.Get<std::string>("Camera.type", kTypes);
  if (type == "PinHole" || type == "Rectified") {
    return ReadPinhole(root, prefix, type == "Rectified");
  }
  if (type == "KannalaBrandt8") {
    return ReadKannalaBrandt(root, prefix);
  }
  root.Fail("Camera.type", kTypes);
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
