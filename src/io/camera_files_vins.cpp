#include "deja_view/base/check.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/mei_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <string>
#include <vector>

#include "camera_files.hpp"

namespace deja_view::internal {
namespace {

template <typename Parameters>
Parameters WithSize(const YamlSection& root) {
  Parameters p;
  p.width = root.GetSize("image_width");
  p.height = root.GetSize("image_height");
  return p;
}

template <typename Parameters>
void ReadRadtan(const YamlSection& root, Parameters* p) {
  const YamlSection distortion = root.Child("distortion_parameters");
  p->k1 = distortion.GetFinite("k1");
  p->k2 = distortion.GetFinite("k2");
  p->p1 = distortion.GetFinite("p1");
  p->p2 = distortion.GetFinite("p2");
}

std::shared_ptr<const Camera> ReadPinhole(const YamlSection& root) {
  auto p = WithSize<PinholeParameters>(root);
  const YamlSection projection = root.Child("projection_parameters");
  p.fx = projection.GetPositive("fx");
  p.fy = projection.GetPositive("fy");
  p.cx = projection.GetFinite("cx");
  p.cy = projection.GetFinite("cy");
  ReadRadtan(root, &p);
  return std::make_shared<PinholeCamera>(p);
}

std::shared_ptr<const Camera> ReadKannalaBrandt(const YamlSection& root) {
  auto p = WithSize<KannalaBrandtParameters>(root);
  const YamlSection projection = root.Child("projection_parameters");
  p.k2 = projection.GetFinite("k2");
  p.k3 = projection.GetFinite("k3");
  p.k4 = projection.GetFinite("k4");
  p.k5 = projection.GetFinite("k5");
  p.mu = projection.GetPositive("mu");
  p.mv = projection.GetPositive("mv");
  p.u0 = projection.GetFinite("u0");
  p.v0 = projection.GetFinite("v0");
  return std::make_shared<KannalaBrandtCamera>(p);
}

std::shared_ptr<const Camera> ReadMei(const YamlSection& root) {
  auto p = WithSize<MeiParameters>(root);
  const YamlSection mirror = root.Child("mirror_parameters");
  p.xi = mirror.GetNotNegative("xi");
  ReadRadtan(root, &p);
  const YamlSection projection = root.Child("projection_parameters");
  p.gamma1 = projection.GetPositive("gamma1");
  p.gamma2 = projection.GetPositive("gamma2");
  p.u0 = projection.GetFinite("u0");
  p.v0 = projection.GetFinite("v0");
  return std::make_shared<MeiCamera>(p);
}

// The camera in camodocal's layout, which both VINS share.
std::shared_ptr<const Camera> ReadCamera(const YamlSection& root) {
  constexpr const char* kModels = "PINHOLE, KANNALA_BRANDT or MEI";
  const auto model = root.Get<std::string>("model_type", kModels);
  if (model == "PINHOLE") {
    return ReadPinhole(root);
  }
  if (model == "KANNALA_BRANDT") {
    return ReadKannalaBrandt(root);
  }
  if (model == "MEI") {
    return ReadMei(root);
  }
  root.Fail("model_type", kModels);
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
