#include "deja_view/base/check.hpp"
#include "deja_view/nerf/posed_images.hpp"

#include <charconv>
#include <utility>

namespace deja_view::nerf {

std::vector<PosedImage> ReadTrajectoryImages(const std::filesystem::path& directory,
                                             std::shared_ptr<const Camera> camera,
                                             const Rigid3& T_B_C,
                                             const Trajectory& T_N_B) {
  constexpr std::int64_t kMaxGap_ns = 100'000'000;
  std::vector<PosedImage> images;
  std::size_t without_pose = 0;
  for (const std::filesystem::path& path : ListImages(directory)) {
    const std::string stem = path.stem().string();
    std::int64_t stamp_ns = 0;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), stamp_ns);
    if (error != std::errc() || end != stem.data() + stem.size() || stamp_ns <= 0) {
      ThrowInputError("{}: expected a stamp in nanoseconds as the image's name", path.string());
    }
    const std::optional<Rigid3> pose = T_N_B.At(stamp_ns, kMaxGap_ns);
    if (!pose) {
      ++without_pose;
      continue;
    }
    images.push_back({path, stem, stamp_ns, camera, *pose * T_B_C});
  }
  if (without_pose > 0) {
    ThrowInputError("{}: {} of {} images have no pose within 0.1 s",
                    directory.string(),
                    without_pose,
                    without_pose + images.size());
  }
  return images;
}

}  // namespace deja_view::nerf
