#include "deja_view/io/image_files.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/io/image_names.hpp"
#include "deja_view/io/trajectory_file.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <string>
#include <system_error>

namespace deja_view {

namespace fs = std::filesystem;

std::vector<fs::path> ListImages(const fs::path& directory) {
  static const std::set<std::string> kExtensions = {
      ".png", ".jpg", ".jpeg", ".webp", ".bmp", ".pgm", ".ppm", ".tif", ".tiff"};
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

std::vector<StampedImage> ListStampedImages(const fs::path& directory) {
  std::vector<StampedImage> images;
  for (const fs::path& path : ListImages(FindAslImages(directory))) {
    const std::optional<std::int64_t> stamp_ns = ParseImageStamp(path.filename().string());
    if (!stamp_ns) {
      ThrowInputError("{}: expected a stamp, in nanoseconds or seconds, as the image's name",
                      path.string());
    }
    images.push_back({*stamp_ns, path});
  }
  std::stable_sort(images.begin(), images.end(), [](const StampedImage& a, const StampedImage& b) {
    return a.stamp_ns < b.stamp_ns;
  });
  for (std::size_t i = 1; i < images.size(); ++i) {
    if (images[i].stamp_ns == images[i - 1].stamp_ns) {
      ThrowInputError("{}: has the stamp of {} too: expected an image per stamp",
                      images[i].path.string(),
                      images[i - 1].path.filename().string());
    }
  }
  return images;
}

}  // namespace deja_view
