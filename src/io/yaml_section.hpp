#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "yaml_file.hpp"
#include <yaml-cpp/yaml.h>

namespace deja_view::internal {

/// Typed access to one map of a camera file. Every getter throws InputError that names file, line
/// and full key, what was expected and what was found.
class YamlSection {
 public:
  /// `path` must outlive the section; `prefix` is what stands before the keys in errors ("cam0.").
  YamlSection(const std::filesystem::path& path, const YAML::Node& node, std::string prefix)
      : path_(path), node_(node), prefix_(std::move(prefix)) {}

  const std::filesystem::path& path() const { return path_; }
  bool Has(const std::string& key) const;
  YamlSection Child(const std::string& key) const;

  template <typename T>
  T Get(const std::string& key, const char* expected) const {
    return Convert<T>(Required(key, expected), key, expected);
  }

  template <typename T>
  T GetOr(const std::string& key, const char* expected, T fallback) const {
    const YAML::Node node = node_[key];
    return node.IsDefined() ? Convert<T>(node, key, expected) : std::move(fallback);
  }

  double GetFinite(const std::string& key) const;
  double GetPositive(const std::string& key) const;
  double GetNotNegative(const std::string& key) const;
  std::vector<double> GetFinites(const std::vector<std::string>& keys) const;

  /// Pixels, from 1 to 32768; of two, the width is the first.
  int GetSize(const std::string& key) const;
  std::array<int, 2> GetTwoSizes(const std::string& key) const;

  /// VINS-Mono writes 0 and 1.
  bool GetFlagOr(const std::string& key, bool fallback) const;

  /// A list of this many finite numbers; `expected` says what they are.
  std::vector<double> GetNumbers(const std::string& key,
                                 std::size_t count,
                                 const std::string& expected) const;

  /// An `!!opencv-matrix` of finite numbers of the given size, row by row.
  std::vector<double> GetMatrix(const std::string& key, int rows, int columns) const;

  /// Rigid transforms [m]: an `!!opencv-matrix` of 4 x 4, a list of four rows, and 16 numbers of
  /// `key`, row by row. The rotation is as ToRotation gives it.
  Rigid3 GetTransform(const std::string& key) const;
  Rigid3 GetTransformOfRows(const std::string& key) const;
  Rigid3 ToTransform(const std::string& key, const std::vector<double>& values) const;

  /// The rotation nearest to a matrix that was read from `key`; it may be off by 1e-3.
  Eigen::Quaterniond ToRotation(const std::string& key, const Eigen::Matrix3d& R) const;

  [[noreturn]] void Fail(const std::string& key, const std::string& expected) const {
    Fail(node_[key], key, expected);
  }

  [[noreturn]] void Fail(const YAML::Node& node,
                         const std::string& key,
                         const std::string& expected) const;

 private:
  YAML::Node Required(const std::string& key, const char* expected) const;
  double ToFinite(const YAML::Node& entry, const std::string& key, const char* expected) const;

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

}  // namespace deja_view::internal
