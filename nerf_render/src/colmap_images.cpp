#include "deja_view/base/check.hpp"
#include "deja_view/io/colmap.hpp"
#include "deja_view/io/image_files.hpp"
#include "deja_view/io/image_names.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <algorithm>
#include <utility>

#include "missing.hpp"

namespace deja_view::nerf {
namespace {

namespace fs = std::filesystem;

// "images" beside the model's files or up to three folders above: project/sparse/0.
fs::path FindImages(const fs::path& model) {
  fs::path folder = fs::absolute(model).lexically_normal();
  for (int level = 0; level < 4; ++level) {
    if (fs::is_directory(folder / "images")) {
      return folder / "images";
    }
    folder = folder.parent_path();
  }
  ThrowInputError("{}: there is no folder 'images' beside or above the model", model.string());
}

std::vector<DepthPoint> MakePoints(const ColmapModel& model, const ColmapImage& image) {
  constexpr std::size_t kMinTrack = 3;
  constexpr double kMaxErrorPx = 2;
  std::vector<DepthPoint> points;
  for (const ColmapObservation& observation : image.observations) {
    const ColmapPoint& point = model.points.at(observation.point);
    if (point.track >= kMinTrack && point.error_px <= kMaxErrorPx) {
      points.push_back({static_cast<float>(observation.pixel.x()),
                        static_cast<float>(observation.pixel.y()),
                        static_cast<float>((point.p_W - image.T_W_C.t).norm())});
    }
  }
  return points;
}

// Images of the folder that the model does not know.
internal::Missing FindUnposed(const std::vector<PosedImage>& posed,
                              const fs::path& folder,
                              std::size_t* total) {
  std::vector<fs::path> known;
  for (const PosedImage& image : posed) {
    known.push_back(image.path.lexically_normal());
  }
  std::sort(known.begin(), known.end());
  internal::Missing missing;
  const std::vector<fs::path> files = ListImages(folder);
  *total = files.size();
  for (const fs::path& file : files) {
    if (!std::binary_search(known.begin(), known.end(), file.lexically_normal())) {
      missing.Add(file.filename().string());
    }
  }
  return missing;
}

}  // namespace

std::vector<PosedImage> ReadColmapImages(const fs::path& model_path,
                                         const fs::path& images,
                                         bool skip_missing) {
  const ColmapModel model = ReadColmapModel(model_path);
  const fs::path folder = images.empty() ? FindImages(model.directory) : images;
  std::vector<PosedImage> posed;
  internal::Missing without_file;
  for (const ColmapImage& image : model.images) {
    PosedImage next;
    next.path = folder / image.name;
    next.name = fs::path(image.name).stem().string();
    next.stamp_ns = ParseImageStamp(image.name).value_or(0);
    next.camera = model.cameras.at(image.camera);
    next.T_N_C = image.T_W_C;
    next.points = MakePoints(model, image);
    if (fs::is_regular_file(next.path)) {
      posed.push_back(std::move(next));
    } else {
      without_file.Add(image.name);
    }
  }
  if (model.images.empty()) {
    ThrowInputError("{}: holds no image", model.directory.string());
  }
  without_file.Check(
      skip_missing, folder.string(), model.images.size(), "poses have no image file");
  std::size_t total = 0;
  const internal::Missing without_pose =
      FindUnposed(posed, posed.front().path.parent_path(), &total);
  without_pose.Check(skip_missing, model.directory.string(), total, "images have no pose");
  DropStrayPoints(&posed);
  return posed;
}

}  // namespace deja_view::nerf
