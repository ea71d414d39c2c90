#include "deja_view/base/check.hpp"
#include "deja_view/camera/camera_parameters.hpp"

#include <array>
#include <string>
#include <vector>

#include "camera_files.hpp"

namespace deja_view::internal {
namespace {

// Focal lengths and principal point.
std::vector<double> ReadProjection(const YamlSection& root,
                                   const std::array<const char*, 4>& keys) {
  const YamlSection section = root.Child("projection_parameters");
  return {section.GetPositive(keys[0]),
          section.GetPositive(keys[1]),
          section.GetFinite(keys[2]),
          section.GetFinite(keys[3])};
}

std::vector<double> ReadRadtan(const YamlSection& root) {
  return root.Child("distortion_parameters").GetFinites({"k1", "k2", "p1", "p2"});
}

// The camera in camodocal's layout, which both VINS share.
std::shared_ptr<const Camera> ReadCamera(const YamlSection& root) {
  constexpr const char* kModels = "PINHOLE, KANNALA_BRANDT or MEI";
  CameraParameters camera;
  camera.model = root.Get<std::string>("model_type", kModels);
  if (camera.model != "PINHOLE" && camera.model != "KANNALA_BRANDT" && camera.model != "MEI") {
    root.Fail("model_type", kModels);
  }
  camera.width = root.GetSize("image_width");
  camera.height = root.GetSize("image_height");
  if (camera.model == "PINHOLE") {
    camera.projection = ReadProjection(root, {"fx", "fy", "cx", "cy"});
    camera.distortion = ReadRadtan(root);
  } else if (camera.model == "KANNALA_BRANDT") {
    camera.distortion = root.Child("projection_parameters").GetFinites({"k2", "k3", "k4", "k5"});
    camera.projection = ReadProjection(root, {"mu", "mv", "u0", "v0"});
  } else {
    camera.projection = {root.Child("mirror_parameters").GetNotNegative("xi")};
    camera.distortion = ReadRadtan(root);
    const std::vector<double> rest = ReadProjection(root, {"gamma1", "gamma2", "u0", "v0"});
    camera.projection.insert(camera.projection.end(), rest.begin(), rest.end());
  }
  return MakeCamera(camera, root.path().string());
}

}  // namespace

CameraFile ReadVinsMonoFile(const YamlSection& root) {
  CameraFile file;
  file.camera = ReadCamera(root);
  const std::vector<double> R = root.GetMatrix("extrinsicRotation", 3, 3);
  file.T_B_C.q =
      root.ToRotation("extrinsicRotation",
                      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()));
  const std::vector<double> t = root.GetMatrix("extrinsicTranslation", 3, 1);
  file.T_B_C.t = {t[0], t[1], t[2]};
  file.image_topic = root.Get<std::string>("image_topic", "a topic name");
  file.imu_topic = root.GetOr<std::string>("imu_topic", "a topic name", "");
  return file;
}

CameraFile ReadVinsFusionFile(const YamlSection& root) {
  constexpr const char* kExpected = "a file with the first camera's model, beside this one";
  const std::filesystem::path camera =
      root.path().parent_path() / root.Get<std::string>("cam0_calib", kExpected);
  if (!std::filesystem::is_regular_file(camera)) {
    root.Fail("cam0_calib", kExpected);
  }
  CameraFile file;
  file.camera = ReadCamera({camera, LoadYamlMap(camera), ""});
  file.T_B_C = root.GetTransform("body_T_cam0");
  file.image_topic = root.Get<std::string>("image0_topic", "a topic name");
  file.imu_topic = root.GetOr<std::string>("imu_topic", "a topic name", "");
  return file;
}

}  // namespace deja_view::internal
