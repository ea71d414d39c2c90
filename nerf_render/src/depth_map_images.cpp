#include "deja_view/base/check.hpp"
#include "deja_view/io/image_files.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <utility>

namespace deja_view::nerf {
namespace {

std::vector<PosedImage> ListSevenScenes(const std::filesystem::path& directory,
                                        const std::shared_ptr<const Camera>& camera) {
  std::vector<PosedImage> maps;
  for (const PosedImage& image : ReadSevenScenes(directory, true, camera)) {
    if (!image.depth.path.empty()) {
      PosedImage map;
      map.stamp_ns = image.stamp_ns;
      map.camera = camera;
      map.depth = image.depth;
      maps.push_back(std::move(map));
    }
  }
  if (maps.empty()) {
    ThrowInputError("{}: expected frame-XXXXXX.depth.png beside the frames", directory.string());
  }
  return maps;
}

}  // namespace

std::vector<PosedImage> ListDepthMaps(const std::filesystem::path& directory,
                                      std::shared_ptr<const Camera> camera,
                                      double unit_m,
                                      bool is_along_ray) {
  std::vector<PosedImage> maps;
  if (std::filesystem::exists(directory / "camera-intrinsics.txt")) {
    maps = ListSevenScenes(directory, camera);
  } else {
    for (const StampedImage& file : ListStampedImages(directory)) {
      PosedImage map;
      map.stamp_ns = file.stamp_ns;
      map.camera = camera;
      map.depth.path = file.path;
      maps.push_back(std::move(map));
    }
  }
  for (PosedImage& map : maps) {
    map.depth.unit_m = unit_m;
    map.depth.is_along_ray = is_along_ray;
  }
  return maps;
}

}  // namespace deja_view::nerf
