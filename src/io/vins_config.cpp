#include "deja_view/io/vins_config.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/mei_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>
#include <optional>
#include <vector>

#include "yaml_file.hpp"

namespace deja_view {
namespace {

// Typed access to one map of the file; every error names file, line and full key.
class Section {
 public:
  Section(const std::filesystem::path& path, const YAML::Node& node, std::string prefix)
      : path_(path), node_(node), prefix_(std::move(prefix)) {}

  Section Child(const std::string& key) const {
    const YAML::Node child = Required(key, "a map");
    if (!child.IsMap()) {
      Fail(child, key, "a map of parameters");
    }
    return {path_, child, prefix_ + key + "."};
  }

  template <typename T>
  T Get(const std::string& key, const char* expected) const {
    return Convert<T>(Required(key, expected), key, expected);
  }

  template <typename T>
  T GetOr(const std::string& key, const char* expected, T fallback) const {
    const YAML::Node node = node_[key];
    return node.IsDefined() ? Convert<T>(node, key, expected) : std::move(fallback);
  }

  double GetFinite(const std::string& key) const {
    const auto value = Get<double>(key, "a number");
    if (!std::isfinite(value)) {
      Fail(node_[key], key, "a finite number");
    }
    return value;
  }

  double GetPositive(const std::string& key) const {
    const double value = GetFinite(key);
    if (value <= 0) {
      Fail(node_[key], key, "a number above 0");
    }
    return value;
  }

  double GetNotNegative(const std::string& key) const {
    const double value = GetFinite(key);
    if (value < 0) {
      Fail(node_[key], key, "0 or more");
    }
    return value;
  }

  int GetSize(const std::string& key) const {
    const int value = Get<int>(key, "a number of pixels");
    if (value < 1 || value > 32768) {
      Fail(node_[key], key, "a number of pixels from 1 to 32768");
    }
    return value;
  }

  // VINS-Mono writes 0 and 1.
  bool GetFlagOr(const std::string& key, bool fallback) const {
    const int value = GetOr<int>(key, "0 or 1", fallback ? 1 : 0);
    if (value != 0 && value != 1) {
      Fail(node_[key], key, "0 or 1");
    }
    return value == 1;
  }

  // An `!!opencv-matrix` of the given size, row by row.
  std::vector<double> GetMatrix(const std::string& key, int rows, int columns) const {
    const std::string expected = fmt::format("an opencv-matrix of {} x {} numbers", rows, columns);
    const YAML::Node node = Required(key, expected.c_str());
    if (!node.IsMap()) {
      Fail(node, key, expected);
    }
    const Section matrix(path_, node, prefix_ + key + ".");
    const bool has_size = matrix.Get<int>("rows", "an integer") == rows &&
                          matrix.Get<int>("cols", "an integer") == columns;
    const YAML::Node data = node["data"];
    if (!has_size || !data.IsDefined() || !data.IsSequence() ||
        data.size() != static_cast<std::size_t>(rows) * columns) {
      Fail(node, key, expected);
    }
    std::vector<double> values;
    for (const YAML::Node& entry : data) {
      values.push_back(Convert<double>(entry, key, expected.c_str()));
      if (!std::isfinite(values.back())) {
        Fail(entry, key, "finite numbers");
      }
    }
    return values;
  }

  [[noreturn]] void Fail(const YAML::Node& node,
                         const std::string& key,
                         const std::string& expected) const {
    const std::string found = node.IsScalar() ? node.Scalar() : "something else";
    ThrowInputError("{}: key '{}{}': expected {}, found '{}'",
                    internal::Where(path_.string(), node.Mark()),
                    prefix_,
                    key,
                    expected,
                    found);
  }

 private:
  YAML::Node Required(const std::string& key, const char* expected) const {
    YAML::Node node = node_[key];
    if (!node.IsDefined() || node.IsNull()) {
      ThrowInputError(
          "{}: key '{}{}' is missing: expected {}", path_.string(), prefix_, key, expected);
    }
    return node;
  }

  template <typename T>
  T Convert(const YAML::Node& node, const std::string& key, const char* expected) const {
    T value{};
    if (!node.IsScalar() || !YAML::convert<T>::decode(node, value)) {
      Fail(node, key, expected);
    }
    return value;
  }

  const std::filesystem::path& path_;
  YAML::Node node_;
  std::string prefix_;
};

std::shared_ptr<const Camera> ReadPinhole(const Section& root) {
  PinholeParameters p;
  p.width = root.GetSize("image_width");
  p.height = root.GetSize("image_height");
  const Section projection = root.Child("projection_parameters");
  p.fx = projection.GetPositive("fx");
  p.fy = projection.GetPositive("fy");
  p.cx = projection.GetFinite("cx");
  p.cy = projection.GetFinite("cy");
  const Section distortion = root.Child("distortion_parameters");
  p.k1 = distortion.GetFinite("k1");
  p.k2 = distortion.GetFinite("k2");
  p.p1 = distortion.GetFinite("p1");
  p.p2 = distortion.GetFinite("p2");
  return std::make_shared<PinholeCamera>(p);
}

std::shared_ptr<const Camera> ReadKannalaBrandt(const Section& root) {
  KannalaBrandtParameters p;
  p.width = root.GetSize("image_width");
  p.height = root.GetSize("image_height");
  const Section projection = root.Child("projection_parameters");
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

std::shared_ptr<const Camera> ReadMei(const Section& root) {
  MeiParameters p;
  p.width = root.GetSize("image_width");
  p.height = root.GetSize("image_height");
  const Section mirror = root.Child("mirror_parameters");
  p.xi = mirror.GetNotNegative("xi");
  const Section distortion = root.Child("distortion_parameters");
  p.k1 = distortion.GetFinite("k1");
  p.k2 = distortion.GetFinite("k2");
  p.p1 = distortion.GetFinite("p1");
  p.p2 = distortion.GetFinite("p2");
  const Section projection = root.Child("projection_parameters");
  p.gamma1 = projection.GetPositive("gamma1");
  p.gamma2 = projection.GetPositive("gamma2");
  p.u0 = projection.GetFinite("u0");
  p.v0 = projection.GetFinite("v0");
  return std::make_shared<MeiCamera>(p);
}

std::shared_ptr<const Camera> ReadCamera(const Section& root, const YAML::Node& node) {
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
  root.Fail(node["model_type"], "model_type", kModels);
}

Eigen::Quaterniond ReadRotation(const std::filesystem::path& path, const Section& root) {
  const std::vector<double> values = root.GetMatrix("extrinsicRotation", 3, 3);
  const Eigen::Matrix3d R =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  const std::optional<Eigen::Quaterniond> q = NearestRotation(R, 1e-3);
  if (!q) {
    ThrowInputError(
        "{}: key 'extrinsicRotation': expected a rotation matrix, found |R R^T - I| = {:.3g} and "
        "determinant {:.3g}",
        path.string(),
        (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(),
        R.determinant());
  }
  return *q;
}

}  // namespace

VinsConfig ReadVinsConfig(const std::filesystem::path& path) {
  const YAML::Node node = internal::LoadYamlMap(path);
  const Section root(path, node, "");
  VinsConfig config;
  config.camera = ReadCamera(root, node);
  config.T_B_C.q = ReadRotation(path, root);
  const std::vector<double> t = root.GetMatrix("extrinsicTranslation", 3, 1);
  config.T_B_C.t = {t[0], t[1], t[2]};
  config.image_topic = root.Get<std::string>("image_topic", "a topic name");
  config.imu_topic = root.GetOr<std::string>("imu_topic", "a topic name", "");
  config.loop_closure = root.GetFlagOr("loop_closure", true);
  config.fast_relocalization = root.GetFlagOr("fast_relocalization", false);
  config.load_previous_pose_graph = root.GetFlagOr("load_previous_pose_graph", false);
  config.pose_graph_save_path = root.GetOr<std::string>("pose_graph_save_path", "a directory", "");
  config.output_path = root.GetOr<std::string>("output_path", "a directory", "");
  config.visualize_camera_size = root.GetOr<double>("visualize_camera_size", "a number", 0.4);
  return config;
}

}  // namespace deja_view
