#include "yaml_section.hpp"

#include "deja_view/base/quote.hpp"

#include <cmath>
#include <optional>

namespace deja_view::internal {

bool YamlSection::Has(const std::string& key) const {
  return node_[key].IsDefined();
}

YamlSection YamlSection::Child(const std::string& key) const {
  const YAML::Node child = Required(key, "a map");
  if (!child.IsMap()) {
    Fail(child, key, "a map of parameters");
  }
  return {path_, child, prefix_ + key + "."};
}

double YamlSection::GetFinite(const std::string& key) const {
  const auto value = Get<double>(key, "a number");
  if (!std::isfinite(value)) {
    Fail(key, "a finite number");
  }
  return value;
}

double YamlSection::GetPositive(const std::string& key) const {
  const double value = GetFinite(key);
  if (value <= 0) {
    Fail(key, "a number above 0");
  }
  return value;
}

double YamlSection::GetNotNegative(const std::string& key) const {
  const double value = GetFinite(key);
  if (value < 0) {
    Fail(key, "0 or more");
  }
  return value;
}

std::vector<double> YamlSection::GetFinites(const std::vector<std::string>& keys) const {
  std::vector<double> values;
  for (const std::string& key : keys) {
    values.push_back(GetFinite(key));
  }
  return values;
}

int YamlSection::GetSize(const std::string& key) const {
  const int value = Get<int>(key, "a number of pixels");
  if (value < 1 || value > 32768) {
    Fail(key, "a number of pixels from 1 to 32768");
  }
  return value;
}

std::array<int, 2> YamlSection::GetTwoSizes(const std::string& key) const {
  constexpr const char* kExpected = "[width, height], each from 1 to 32768 pixels";
  std::array<int, 2> sizes{};
  const std::vector<double> values = GetNumbers(key, sizes.size(), kExpected);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (values[i] < 1 || values[i] > 32768 || values[i] != std::floor(values[i])) {
      Fail(node_[key][i], key, kExpected);
    }
    sizes[i] = static_cast<int>(values[i]);
  }
  return sizes;
}

bool YamlSection::GetFlagOr(const std::string& key, bool fallback) const {
  const int value = GetOr<int>(key, "0 or 1", fallback ? 1 : 0);
  if (value != 0 && value != 1) {
    Fail(key, "0 or 1");
  }
  return value == 1;
}

std::vector<double> YamlSection::GetNumbers(const std::string& key,
                                            std::size_t count,
                                            const std::string& expected) const {
  const YAML::Node node = Required(key, expected.c_str());
  if (!node.IsSequence()) {
    Fail(node, key, expected);
  }
  if (node.size() != count) {
    ThrowInputError("{}: key '{}{}': expected {}, found {} values",
                    Where(path_.string(), node.Mark()),
                    prefix_,
                    key,
                    expected,
                    node.size());
  }
  std::vector<double> values;
  for (const YAML::Node& entry : node) {
    values.push_back(ToFinite(entry, key, expected.c_str()));
  }
  return values;
}

std::vector<double> YamlSection::GetMatrix(const std::string& key, int rows, int columns) const {
  const std::string expected = fmt::format("an opencv-matrix of {} x {} numbers", rows, columns);
  const YAML::Node node = Required(key, expected.c_str());
  if (!node.IsMap()) {
    Fail(node, key, expected);
  }
  const YamlSection matrix(path_, node, prefix_ + key + ".");
  const bool has_size = matrix.Get<int>("rows", "an integer") == rows &&
                        matrix.Get<int>("cols", "an integer") == columns;
  const YAML::Node data = node["data"];
  if (!has_size || !data.IsDefined() || !data.IsSequence() ||
      data.size() != static_cast<std::size_t>(rows) * columns) {
    Fail(node, key, expected);
  }
  std::vector<double> values;
  for (const YAML::Node& entry : data) {
    values.push_back(ToFinite(entry, key, expected.c_str()));
  }
  return values;
}

Rigid3 YamlSection::GetTransform(const std::string& key) const {
  return ToTransform(key, GetMatrix(key, 4, 4));
}

Rigid3 YamlSection::GetTransformOfRows(const std::string& key) const {
  constexpr const char* kExpected = "a list of 4 rows of 4 numbers";
  const YAML::Node node = Required(key, kExpected);
  if (!node.IsSequence() || node.size() != 4) {
    Fail(node, key, kExpected);
  }
  std::vector<double> values;
  for (const YAML::Node& row : node) {
    if (!row.IsSequence() || row.size() != 4) {
      Fail(row, key, kExpected);
    }
    for (const YAML::Node& entry : row) {
      values.push_back(ToFinite(entry, key, kExpected));
    }
  }
  return ToTransform(key, values);
}

Eigen::Quaterniond YamlSection::ToRotation(const std::string& key, const Eigen::Matrix3d& R) const {
  const std::optional<Eigen::Quaterniond> q = NearestRotation(R, 1e-3);
  if (!q) {
    ThrowInputError(
        "{}: key '{}{}': expected a rotation matrix, found |R R^T - I| = {:.3g} and "
        "determinant {:.3g}",
        path_.string(),
        prefix_,
        key,
        (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(),
        R.determinant());
  }
  return *q;
}

void YamlSection::Fail(const YAML::Node& node,
                       const std::string& key,
                       const std::string& expected) const {
  const std::string found = node.IsScalar() ? Quote(node.Scalar()) : "something else";
  ThrowInputError("{}: key '{}{}': expected {}, found {}",
                  Where(path_.string(), node.Mark()),
                  prefix_,
                  key,
                  expected,
                  found);
}

YAML::Node YamlSection::Required(const std::string& key, const char* expected) const {
  YAML::Node node = node_[key];
  if (!node.IsDefined() || node.IsNull()) {
    ThrowInputError(
        "{}: key '{}{}' is missing: expected {}", path_.string(), prefix_, key, expected);
  }
  return node;
}

double YamlSection::ToFinite(const YAML::Node& entry,
                             const std::string& key,
                             const char* expected) const {
  const auto value = Convert<double>(entry, key, expected);
  if (!std::isfinite(value)) {
    Fail(entry, key, "finite numbers");
  }
  return value;
}

Rigid3 YamlSection::ToTransform(const std::string& key, const std::vector<double>& values) const {
  const Eigen::Matrix4d T =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  if (T.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    ThrowInputError("{}: key '{}{}': expected a last row of 0, 0, 0, 1, found {}, {}, {}, {}",
                    Where(path_.string(), node_[key].Mark()),
                    prefix_,
                    key,
                    T(3, 0),
                    T(3, 1),
                    T(3, 2),
                    T(3, 3));
  }
  return {ToRotation(key, T.topLeftCorner<3, 3>()), T.topRightCorner<3, 1>()};
}

}  // namespace deja_view::internal
