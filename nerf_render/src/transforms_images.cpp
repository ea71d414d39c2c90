#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/io/image_names.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "missing.hpp"
#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace deja_view::nerf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Keys of one frame, or else of the whole file.
class Keys {
 public:
  Keys(const Json& root, const Json& frame, std::string where)
      : root_(root), frame_(frame), where_(std::move(where)) {}

  std::optional<double> Number(const char* key) const {
    const Json* value = Find(key);
    if (value == nullptr) {
      return std::nullopt;
    }
    if (!value->is_number() || !std::isfinite(value->get<double>())) {
      Fail(fmt::format("key '{}': expected a finite number, found {}", key, Quote(value->dump())));
    }
    return value->get<double>();
  }
  double NumberOr(const char* key, double fallback) const { return Number(key).value_or(fallback); }
  std::optional<std::string> Text(const char* key) const {
    const Json* value = Find(key);
    if (value == nullptr) {
      return std::nullopt;
    }
    if (!value->is_string()) {
      Fail(fmt::format("key '{}': expected text, found {}", key, Quote(value->dump())));
    }
    return value->get<std::string>();
  }
  bool Flag(const char* key) const {
    const Json* value = Find(key);
    return value != nullptr && *value == true;
  }
  const Json* Find(const char* key) const {
    for (const Json* place : {&frame_, &root_}) {
      const auto found = place->find(key);
      if (found != place->end()) {
        return &*found;
      }
    }
    return nullptr;
  }
  [[noreturn]] void Fail(const std::string& what) const { ThrowInputError("{}: {}", where_, what); }

 private:
  const Json& root_;
  const Json& frame_;
  std::string where_;
};

// COLMAP's convention, in which these files are written: (0, 0) is the corner of the first pixel.
constexpr double kHalfPixel = 0.5;

struct Lens {
  bool is_fisheye = false;
  int width = 0;
  int height = 0;
  std::array<double, 8> numbers{};  // fx fy cx cy and four of distortion

  bool operator<(const Lens& other) const {
    return std::tie(is_fisheye, width, height, numbers) <
           std::tie(other.is_fisheye, other.width, other.height, other.numbers);
  }
};

int ReadSide(const Keys& keys, const char* key, int of_file) {
  constexpr double kMaxSide = 65536;
  const double side = keys.NumberOr(key, of_file);
  if (!(side >= 1 && side <= kMaxSide) || side != std::floor(side)) {
    keys.Fail(fmt::format("key '{}': expected a number of pixels, found {}", key, side));
  }
  return static_cast<int>(side);
}

double FocalLength(const Keys& keys, const char* key, const char* angle_key, int side) {
  const auto focal_length = keys.Number(key);
  const auto angle = keys.Number(angle_key);
  const double value =
      focal_length ? *focal_length : (angle ? 0.5 * side / std::tan(0.5 * *angle) : 0);
  // An angle of next to nothing has a focal length that is no number.
  if ((focal_length || angle) && !(value > 0 && std::isfinite(value))) {
    keys.Fail(fmt::format("key '{}': expected a number above 0", focal_length ? key : angle_key));
  }
  return value;
}

bool IsFisheye(const Keys& keys) {
  const std::string model = keys.Text("camera_model").value_or("OPENCV");
  for (const char* known : {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "RADIAL", "SIMPLE_RADIAL"}) {
    if (model == known) {
      return keys.Flag("is_fisheye");
    }
  }
  if (model != "OPENCV_FISHEYE") {
    keys.Fail(
        fmt::format("camera_model {}: expected PINHOLE, OPENCV or OPENCV_FISHEYE", Quote(model)));
  }
  return true;
}

Lens ReadLens(const Keys& keys, cv::Size of_file) {
  Lens lens;
  lens.is_fisheye = IsFisheye(keys);
  lens.width = ReadSide(keys, "w", of_file.width);
  lens.height = ReadSide(keys, "h", of_file.height);
  const double fx = FocalLength(keys, "fl_x", "camera_angle_x", lens.width);
  const double fy = FocalLength(keys, "fl_y", "camera_angle_y", lens.height);
  if (!(fx > 0) && !(fy > 0)) {
    keys.Fail("expected fl_x or camera_angle_x");
  }
  const double cx = keys.NumberOr("cx", 0.5 * lens.width) - kHalfPixel;
  const double cy = keys.NumberOr("cy", 0.5 * lens.height) - kHalfPixel;
  const char* third = lens.is_fisheye ? "k3" : "p1";
  const char* fourth = lens.is_fisheye ? "k4" : "p2";
  for (const char* unknown : {"k3", "k4"}) {
    if (!lens.is_fisheye && keys.NumberOr(unknown, 0) != 0) {
      keys.Fail(fmt::format("key '{}': expected 0 for a camera that is no fisheye", unknown));
    }
  }
  lens.numbers = {fx > 0 ? fx : fy,
                  fy > 0 ? fy : fx,
                  cx,
                  cy,
                  keys.NumberOr("k1", 0),
                  keys.NumberOr("k2", 0),
                  keys.NumberOr(third, 0),
                  keys.NumberOr(fourth, 0)};
  return lens;
}

std::shared_ptr<const Camera> MakeCamera(const Lens& lens) {
  const auto& n = lens.numbers;
  if (lens.is_fisheye) {
    return std::make_shared<KannalaBrandtCamera>(KannalaBrandtParameters{
        lens.width, lens.height, n[4], n[5], n[6], n[7], n[0], n[1], n[2], n[3]});
  }
  return std::make_shared<PinholeCamera>(
      PinholeParameters{lens.width, lens.height, n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7]});
}

Rigid3 ReadPose(const Keys& keys) {
  constexpr double kTolerance = 5e-3;
  const Json* rows = keys.Find("transform_matrix");
  Eigen::Matrix4d T = Eigen::Matrix4d::Zero();
  T(3, 3) = 1;
  const bool has_rows =
      rows != nullptr && rows->is_array() && (rows->size() == 3 || rows->size() == 4);
  for (std::size_t row = 0; has_rows && row < rows->size(); ++row) {
    const Json& values = (*rows)[row];
    for (std::size_t column = 0; column < 4; ++column) {
      const bool is_number = values.is_array() && values.size() == 4 && values[column].is_number();
      T(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
          is_number ? values[column].get<double>() : std::nan("");
    }
  }
  const auto q = NearestRotation(T.topLeftCorner<3, 3>(), kTolerance);
  if (!has_rows || !T.allFinite() || !q || T.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    keys.Fail("key 'transform_matrix': expected a rigid 4 x 4 pose, camera to world");
  }
  return FromRightUpBack({*q, T.topRightCorner<3, 1>()});
}

Json ReadJson(const fs::path& path) {
  std::ifstream stream = OpenInputFile(path);
  Json root = Json::parse(stream, nullptr, false);
  const auto frames = root.is_object() ? root.find("frames") : root.end();
  if (!root.is_object() || frames == root.end() || !frames->is_array() || frames->empty()) {
    ThrowInputError("{}: expected JSON with an array 'frames' that holds frames", path.string());
  }
  return root;
}

// The file itself, or with an extension that was left out.
fs::path FindImage(const fs::path& path) {
  for (const char* extension : {"", ".png", ".jpg", ".jpeg"}) {
    fs::path candidate = path;
    candidate += extension;
    if (fs::is_regular_file(candidate)) {
      return candidate;
    }
  }
  return {};
}

cv::Size SizeOf(const fs::path& path) {
  const cv::Mat image =
      cv::imread(path.string(), cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  if (image.empty()) {
    ThrowInputError("{}: can't be read as an image", path.string());
  }
  return image.size();
}

PosedImage ReadFrame(const Keys& keys,
                     const fs::path& directory,
                     const fs::path& path,
                     std::map<Lens, std::shared_ptr<const Camera>>* cameras) {
  PosedImage image;
  image.path = path;
  image.name = path.stem().string();
  image.stamp_ns = ParseImageStamp(path.filename().string()).value_or(0);
  image.T_N_C = ReadPose(keys);
  const bool has_size = keys.Find("w") != nullptr && keys.Find("h") != nullptr;
  const Lens lens = ReadLens(keys, has_size ? cv::Size() : SizeOf(path));
  auto& camera = (*cameras)[lens];
  if (camera == nullptr) {
    camera = MakeCamera(lens);
  }
  image.camera = camera;
  if (const auto depth = keys.Text("depth_file_path")) {
    image.depth.path = directory / *depth;
    image.depth.unit_m = keys.NumberOr("depth_unit_scale_factor", 1e-3);
    if (!(image.depth.unit_m > 0)) {
      keys.Fail("key 'depth_unit_scale_factor': expected a number above 0");
    }
  }
  return image;
}

}  // namespace

Rigid3 FromRightUpBack(const Rigid3& T_N_nerf) {
  // Half a turn about x.
  return {T_N_nerf.q * Eigen::Quaterniond(0, 1, 0, 0), T_N_nerf.t};
}

std::vector<PosedImage> ReadTransforms(const fs::path& file, bool skip_missing) {
  const Json root = ReadJson(file);
  const fs::path directory = file.parent_path();
  std::map<Lens, std::shared_ptr<const Camera>> cameras;
  std::vector<PosedImage> images;
  internal::Missing missing;
  const Json& frames = root["frames"];
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Keys keys(root, frames[i], fmt::format("{}: frame {}", file.string(), i));
    const auto name = frames[i].is_object() ? keys.Text("file_path") : std::nullopt;
    if (!name) {
      keys.Fail("key 'file_path': expected the path of an image");
    }
    const fs::path path = FindImage(directory / *name);
    if (path.empty()) {
      missing.Add(*name);
    } else {
      images.push_back(ReadFrame(keys, directory, path, &cameras));
    }
  }
  missing.Check(skip_missing, file.string(), frames.size(), "frames have no image file");
  std::stable_sort(images.begin(), images.end(), [](const PosedImage& a, const PosedImage& b) {
    return a.path < b.path;
  });
  return images;
}

}  // namespace deja_view::nerf
