#include "deja_view/io/colmap.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/io/image_names.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "colmap_parts.hpp"

namespace deja_view {
namespace internal {
namespace {

constexpr std::array<ColmapCameraModel, 11> kModels = {{{"SIMPLE_PINHOLE", 0, 3},
                                                        {"PINHOLE", 1, 4},
                                                        {"SIMPLE_RADIAL", 2, 4},
                                                        {"RADIAL", 3, 5},
                                                        {"OPENCV", 4, 8},
                                                        {"OPENCV_FISHEYE", 5, 8},
                                                        {"FULL_OPENCV", 6, 12},
                                                        {"FOV", 7, 5},
                                                        {"SIMPLE_RADIAL_FISHEYE", 8, 4},
                                                        {"RADIAL_FISHEYE", 9, 5},
                                                        {"THIN_PRISM_FISHEYE", 10, 12}}};

// COLMAP's (0, 0) is the corner of the top left pixel.
constexpr double kHalfPixel = 0.5;

struct Lens {
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  std::array<double, 4> distortion{};  // k1 k2 p1 p2, or k1 to k4 of a fisheye
};

Lens MakeLens(const ColmapCameraModel& model, const std::vector<double>& p) {
  const std::string name = model.name;
  const bool one_focal_length = name.rfind("SIMPLE_", 0) == 0 || name.rfind("RADIAL", 0) == 0;
  Lens lens;
  std::size_t next = 0;
  lens.fx = p[next++];
  lens.fy = one_focal_length ? lens.fx : p[next++];
  lens.cx = p[next++] - kHalfPixel;
  lens.cy = p[next++] - kHalfPixel;
  std::copy(p.begin() + static_cast<std::ptrdiff_t>(next), p.end(), lens.distortion.begin());
  return lens;
}

}  // namespace

const ColmapCameraModel* FindColmapCameraModel(const std::string& name) {
  const auto* found = std::find_if(
      kModels.begin(), kModels.end(), [&](const auto& model) { return name == model.name; });
  return found == kModels.end() ? nullptr : found;
}

const ColmapCameraModel* FindColmapCameraModel(int id) {
  const auto* found = std::find_if(
      kModels.begin(), kModels.end(), [&](const auto& model) { return id == model.id; });
  return found == kModels.end() ? nullptr : found;
}

std::shared_ptr<const Camera> MakeColmapCamera(const ColmapCameraModel& model,
                                               std::uint64_t width,
                                               std::uint64_t height,
                                               const std::vector<double>& parameters,
                                               const ColmapFail& fail) {
  constexpr std::uint64_t kMaxSide = 65536;
  const std::string name = model.name;
  if (name == "FULL_OPENCV" || name == "FOV" || name == "THIN_PRISM_FISHEYE") {
    fail(
        fmt::format("camera model {}: expected SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, "
                    "OPENCV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE or OPENCV_FISHEYE",
                    name));
  }
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    fail(fmt::format("a camera of {} x {} px", width, height));
  }
  if (!std::all_of(
          parameters.begin(), parameters.end(), [](double v) { return std::isfinite(v); })) {
    fail("camera parameters that are not finite");
  }
  const Lens lens = MakeLens(model, parameters);
  if (!(lens.fx > 0) || !(lens.fy > 0)) {
    fail(fmt::format("focal lengths {} and {}: expected more than 0", lens.fx, lens.fy));
  }
  const auto& d = lens.distortion;
  const int w = static_cast<int>(width);
  const int h = static_cast<int>(height);
  if (name.find("FISHEYE") != std::string::npos) {
    return std::make_shared<KannalaBrandtCamera>(
        KannalaBrandtParameters{w, h, d[0], d[1], d[2], d[3], lens.fx, lens.fy, lens.cx, lens.cy});
  }
  return std::make_shared<PinholeCamera>(
      PinholeParameters{w, h, lens.fx, lens.fy, lens.cx, lens.cy, d[0], d[1], d[2], d[3]});
}

Rigid3 MakeColmapPose(const std::vector<double>& v, const ColmapFail& fail) {
  Rigid3 T_C_W{Eigen::Quaterniond(v[0], v[1], v[2], v[3]), {v[4], v[5], v[6]}};
  if (!T_C_W.IsFinite() || !(std::abs(T_C_W.q.norm() - 1) < 1e-2)) {
    fail("expected a finite pose with a quaternion of norm 1");
  }
  T_C_W.q.normalize();
  return T_C_W.Inverse();
}

}  // namespace internal

namespace {

namespace fs = std::filesystem;

bool HasModel(const fs::path& directory, const char* extension) {
  return fs::is_regular_file(directory / (std::string("cameras") + extension)) &&
         fs::is_regular_file(directory / (std::string("images") + extension));
}

std::optional<fs::path> FindModel(const fs::path& directory) {
  for (const fs::path& candidate :
       {directory, directory / "sparse/0", directory / "sparse", directory / "0"}) {
    if (HasModel(candidate, ".bin") || HasModel(candidate, ".txt")) {
      return candidate;
    }
  }
  return std::nullopt;
}

fs::path ImagesFile(const fs::path& directory) {
  return directory / (HasModel(directory, ".bin") ? "images.bin" : "images.txt");
}

// Drops observations of no point, or of one that the model lacks.
void KeepObservedPoints(ColmapModel* model) {
  for (ColmapImage& image : model->images) {
    auto& all = image.observations;
    all.erase(std::remove_if(all.begin(),
                             all.end(),
                             [&](const auto& o) { return model->points.count(o.point) == 0; }),
              all.end());
  }
}

}  // namespace

bool IsColmapModel(const fs::path& directory) {
  return FindModel(directory).has_value();
}

ColmapModel ReadColmapModel(const fs::path& directory) {
  const std::optional<fs::path> found = FindModel(directory);
  if (!found) {
    ThrowInputError(
        "{}: expected COLMAP's cameras, images and points3D, .bin or .txt, here or in sparse/0",
        directory.string());
  }
  ColmapModel model;
  model.directory = *found;
  if (HasModel(*found, ".bin")) {
    internal::ReadColmapBinary(&model);
  } else {
    internal::ReadColmapText(&model);
  }
  for (const ColmapImage& image : model.images) {
    if (model.cameras.count(image.camera) == 0) {
      ThrowInputError("{}: image {} is of camera {}, which the model lacks",
                      ImagesFile(*found).string(),
                      Quote(image.name),
                      image.camera);
    }
  }
  std::sort(model.images.begin(), model.images.end(), [](const auto& a, const auto& b) {
    return a.name < b.name;
  });
  KeepObservedPoints(&model);
  return model;
}

Trajectory ToTrajectory(const ColmapModel& model) {
  std::map<std::int64_t, const ColmapImage*> by_stamp;
  for (const ColmapImage& image : model.images) {
    const auto stamp_ns = ParseImageStamp(image.name);
    if (!stamp_ns) {
      ThrowInputError("{}: image {}: expected a stamp, in nanoseconds or seconds, as its name",
                      ImagesFile(model.directory).string(),
                      Quote(image.name));
    }
    const auto [at, is_new] = by_stamp.emplace(*stamp_ns, &image);
    if (!is_new) {
      ThrowInputError("{}: images {} and {} have the same stamp",
                      ImagesFile(model.directory).string(),
                      Quote(at->second->name),
                      Quote(image.name));
    }
  }
  Trajectory trajectory;
  for (const auto& [stamp_ns, image] : by_stamp) {
    trajectory.stamps_ns.push_back(stamp_ns);
    trajectory.poses.push_back(image->T_W_C);
  }
  return trajectory;
}

}  // namespace deja_view
