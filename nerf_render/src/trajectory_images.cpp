#include "deja_view/base/check.hpp"
#include "deja_view/io/image_files.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <optional>
#include <utility>

#include "missing.hpp"

namespace deja_view::nerf {

namespace fs = std::filesystem;

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
  for (const StampedImage& file : ListStampedImages(directory)) {
    PosedImage image;
    image.path = file.path;
    image.name = file.path.stem().string();
    image.stamp_ns = file.stamp_ns;
    image.camera = camera;
    images.push_back(std::move(image));
  }
  return AttachPoses(std::move(images), T_B_C, T_N_B, skip_missing, directory.string());
}

}  // namespace deja_view::nerf
