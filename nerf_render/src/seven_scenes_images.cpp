#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "missing.hpp"
#include <Eigen/Core>
#include <opencv2/imgcodecs.hpp>

namespace deja_view::nerf {
namespace {

namespace fs = std::filesystem;

template <int Size>
Eigen::Matrix<double, Size, Size> ReadMatrix(const fs::path& path) {
  std::ifstream stream = OpenInputFile(path);
  Eigen::Matrix<double, Size, Size> matrix;
  for (Eigen::Index row = 0; row < Size; ++row) {
    for (Eigen::Index column = 0; column < Size; ++column) {
      if (!(stream >> matrix(row, column)) || !std::isfinite(matrix(row, column))) {
        ThrowInputError("{}: expected {} x {} finite numbers", path.string(), Size, Size);
      }
    }
  }
  return matrix;
}

Rigid3 ReadPose(const fs::path& path) {
  constexpr double kTolerance = 5e-3;  // the poses come with few digits
  const Eigen::Matrix4d T = ReadMatrix<4>(path);
  const auto q = NearestRotation(T.topLeftCorner<3, 3>(), kTolerance);
  if (!q || T.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    ThrowInputError("{}: expected a rigid 4 x 4 pose, camera to world", path.string());
  }
  return {*q, T.topRightCorner<3, 1>()};
}

std::shared_ptr<const Camera> ReadCamera(const fs::path& directory, const fs::path& first_image) {
  const fs::path path = directory / "camera-intrinsics.txt";
  const Eigen::Matrix3d K = ReadMatrix<3>(path);
  if (!(K(0, 0) > 0 && K(1, 1) > 0) || K(0, 1) != 0 || K(2, 2) != 1) {
    ThrowInputError("{}: expected 'fx 0 cx', '0 fy cy', '0 0 1'", path.string());
  }
  const cv::Mat image = cv::imread(first_image.string(), cv::IMREAD_UNCHANGED);
  if (image.empty()) {
    ThrowInputError("{}: can't be read as an image", first_image.string());
  }
  PinholeParameters p;
  p.width = image.cols;
  p.height = image.rows;
  p.fx = K(0, 0);
  p.fy = K(1, 1);
  p.cx = K(0, 2);
  p.cy = K(1, 2);
  return std::make_shared<PinholeCamera>(p);
}

struct FrameFiles {
  fs::path color;
  fs::path pose;
  fs::path depth;
};

// "frame-000012.color.jpg": number 12, what "color".
std::map<std::int64_t, FrameFiles> ListFrames(const fs::path& directory) {
  const std::string prefix = "frame-";
  std::map<std::int64_t, FrameFiles> frames;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    const std::size_t point = name.find('.');
    std::int64_t number = 0;
    if (name.rfind(prefix, 0) != 0 || point == std::string::npos) {
      continue;
    }
    const char* end = name.data() + point;
    const auto result = std::from_chars(name.data() + prefix.size(), end, number);
    if (result.ec != std::errc() || result.ptr != end) {
      continue;
    }
    const std::string what = name.substr(point + 1, name.find('.', point + 1) - point - 1);
    if (what == "color") {
      frames[number].color = entry.path();
    } else if (what == "pose") {
      frames[number].pose = entry.path();
    } else if (what == "depth") {
      frames[number].depth = entry.path();
    }
  }
  if (error) {
    ThrowInputError("{}: can't be listed: {}", directory.string(), error.message());
  }
  return frames;
}

}  // namespace

std::vector<PosedImage> ReadSevenScenes(const fs::path& directory,
                                        bool skip_missing,
                                        const std::shared_ptr<const Camera>& color_camera) {
  constexpr std::int64_t kFirstNs = 1'000'000'000'000;
  constexpr double kPeriodNs = 1e9 / 30;
  std::vector<PosedImage> images;
  internal::Missing without_image;
  internal::Missing without_pose;
  const std::map<std::int64_t, FrameFiles> frames = ListFrames(directory);
  for (const auto& [number, files] : frames) {
    const std::string name = fmt::format("frame-{:06}", number);
    if (files.color.empty() || files.pose.empty()) {
      (files.color.empty() ? without_image : without_pose).Add(name);
      continue;
    }
    PosedImage image;
    image.path = files.color;
    image.name = name;
    image.stamp_ns = kFirstNs + std::llround(static_cast<double>(number) * kPeriodNs);
    image.T_N_C = ReadPose(files.pose);
    image.depth.path = files.depth;
    images.push_back(std::move(image));
  }
  const std::string where = directory.string();
  without_image.Check(skip_missing, where, frames.size(), "frames have no color image");
  without_pose.Check(skip_missing, where, frames.size(), "frames have no pose.txt");
  if (images.empty()) {
    ThrowInputError("{}: expected frame-XXXXXX.color.png or .jpg with .pose.txt", where);
  }
  const auto camera = ReadCamera(directory, images.front().path);
  for (PosedImage& image : images) {
    image.camera = color_camera ? color_camera : camera;
    image.depth.camera = color_camera ? camera : nullptr;
  }
  return images;
}

}  // namespace deja_view::nerf
