#include "deja_view/camera/camera_parameters.hpp"

#include <string>
#include <vector>

#include "camera_files.hpp"

namespace deja_view::internal {
namespace {

constexpr const char* kFocalLengths = "focal lengths above 0";

// k1, k2, p1, p2 of radtan, or k1 ... k4 of equidistant; zeros of none.
struct Distortion {
  bool is_equidistant = false;
  std::vector<double> k = std::vector<double>(4, 0.0);
};

Distortion ReadDistortion(const YamlSection& camera, const std::string& coefficients) {
  constexpr const char* kModels = "radtan (radial-tangential), equidistant or none";
  const auto model = camera.Get<std::string>("distortion_model", kModels);
  Distortion distortion;
  if (model == "none") {
    return distortion;
  }
  distortion.is_equidistant = model == "equidistant";
  if (!distortion.is_equidistant && model != "radtan" && model != "radial-tangential") {
    camera.Fail("distortion_model", kModels);
  }
  distortion.k = camera.GetNumbers(
      coefficients,
      4,
      distortion.is_equidistant ? "4 numbers: k1, k2, k3, k4" : "4 numbers: k1, k2, p1, p2");
  return distortion;
}

std::shared_ptr<const Camera> MakeCameraOf(const YamlSection& camera,
                                           const char* model,
                                           const std::vector<double>& distortion,
                                           const std::vector<double>& projection) {
  const auto [width, height] = camera.GetTwoSizes("resolution");
  return MakeCamera({model, width, height, distortion, projection}, camera.path().string());
}

std::shared_ptr<const Camera> ReadPinhole(const YamlSection& camera,
                                          const std::string& coefficients) {
  const auto [is_equidistant, k] = ReadDistortion(camera, coefficients);
  const std::vector<double> f = camera.GetNumbers("intrinsics", 4, "4 numbers: fx, fy, cx, cy");
  if (f[0] <= 0 || f[1] <= 0) {
    camera.Fail("intrinsics", kFocalLengths);
  }
  return MakeCameraOf(camera, is_equidistant ? "KANNALA_BRANDT" : "PINHOLE", k, f);
}

std::shared_ptr<const Camera> ReadOmni(const YamlSection& camera) {
  const auto [is_equidistant, k] = ReadDistortion(camera, "distortion_coeffs");
  if (is_equidistant) {
    camera.Fail("distortion_model", "radtan or none beside camera_model omni");
  }
  const std::vector<double> f = camera.GetNumbers("intrinsics", 5, "5 numbers: xi, fx, fy, cx, cy");
  if (f[0] < 0) {
    camera.Fail("intrinsics", "a mirror parameter xi of 0 or more");
  }
  if (f[1] <= 0 || f[2] <= 0) {
    camera.Fail("intrinsics", kFocalLengths);
  }
  return MakeCameraOf(camera, "MEI", k, f);
}

std::shared_ptr<const Camera> ReadChainCamera(const YamlSection& camera) {
  constexpr const char* kModels = "pinhole or omni";
  const auto model = camera.Get<std::string>("camera_model", kModels);
  if (model == "pinhole") {
    return ReadPinhole(camera, "distortion_coeffs");
  }
  if (model == "omni") {
    return ReadOmni(camera);
  }
  camera.Fail("camera_model", kModels);
}

Rigid3 ReadChainExtrinsic(const YamlSection& camera) {
  if (!camera.Has("T_imu_cam")) {
    return camera.GetTransformOfRows("T_cam_imu").Inverse();
  }
  Rigid3 T_B_C = camera.GetTransformOfRows("T_imu_cam");
  if (camera.Has("T_cam_imu")) {
    const Rigid3 difference = camera.GetTransformOfRows("T_cam_imu") * T_B_C;
    if (RotationAngle(difference.q) > 1e-3 || difference.t.norm() > 1e-3) {
      camera.Fail("T_cam_imu", "the inverse of T_imu_cam");
    }
  }
  return T_B_C;
}

}  // namespace

CameraFile ReadKalibrChain(const YamlSection& root) {
  const YamlSection camera = root.Child("cam0");
  CameraFile file;
  file.camera = ReadChainCamera(camera);
  file.T_B_C = ReadChainExtrinsic(camera);
  file.image_topic = camera.GetOr<std::string>("rostopic", "a topic name", "");
  return file;
}

CameraFile ReadAslSensor(const YamlSection& root) {
  constexpr const char* kModel = "pinhole";
  CameraFile file;
  if (root.Get<std::string>("camera_model", kModel) != kModel) {
    root.Fail("camera_model", kModel);
  }
  file.camera = ReadPinhole(root, "distortion_coefficients");
  const YamlSection T_BS = root.Child("T_BS");
  file.T_B_C = T_BS.ToTransform("data", T_BS.GetNumbers("data", 16, "16 numbers, row by row"));
  return file;
}

}  // namespace deja_view::internal
