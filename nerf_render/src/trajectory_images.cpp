#include "deja_view/base/check.hpp"
#include "deja_view/io/image_names.hpp"
#include "deja_view/io/trajectory_file.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <utility>

#include "missing.hpp"

namespace deja_view::nerf {

namespace fs = std::filesystem;

std::vector<fs::path> ListImages(const fs::path& directory) {
  static const std::set<std::string> kExtensions = {
      ".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp"};
  std::vector<fs::path> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
      return static_cast<char>(std::tolower(c));
    });
    if (kExtensions.count(extension) > 0 && entry.path().stem().extension() != ".depth") {
      paths.push_back(entry.path());
    }
  }
  if (error) {
    ThrowInputError("{}: can't be listed: {}", directory.string(), error.message());
  }
  if (paths.empty()) {
    ThrowInputError("{}: holds no image", directory.string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<PosedImage> AttachPoses(std::vector<PosedImage> images,
                                    const Rigid3& T_B_C,
                                    const Trajectory& T_N_B,
                                    bool skip_missing,
                                    const std::string& where) {
  constexpr std::int64_t kMaxGap_ns = 100'000'000;
  std::vector<PosedImage> posed;
  internal::Missing missing;
  for (PosedImage& image : images) {
    const std::optional<Rigid3> T = T_N_B.At(image.stamp_ns, kMaxGap_ns);
    if (T) {
      image.T_N_C = *T * T_B_C;
      posed.push_back(std::move(image));
    } else {
      missing.Add(image.name);
    }
  }
  missing.Check(skip_missing, where, images.size(), "images have no pose within 0.1 s");
  return posed;
}

std::vector<PosedImage> ReadTrajectoryImages(const fs::path& directory,
                                             std::shared_ptr<const Camera> camera,
                                             const Rigid3& T_B_C,
                                             const Trajectory& T_N_B,
                                             bool skip_missing) {
  std::vector<PosedImage> images;
  for (const fs::path& path : ListImages(FindAslImages(directory))) {
    const std::optional<std::int64_t> stamp_ns = ParseImageStamp(path.filename().string());
    if (!stamp_ns) {
      ThrowInputError("{}: expected a stamp, in nanoseconds or seconds, as the image's name",
                      path.string());
    }
    PosedImage image;
    image.path = path;
    image.name = path.stem().string();
    image.stamp_ns = *stamp_ns;
    image.camera = camera;
    images.push_back(std::move(image));
  }
  return AttachPoses(std::move(images), T_B_C, T_N_B, skip_missing, directory.string());
}

}  // namespace deja_view::nerf
