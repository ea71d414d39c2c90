#include "deja_view/base/check.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <cstdlib>
#include <map>
#include <optional>

namespace deja_view::nerf {
namespace {

// VIOs compute with stamps in double seconds, which rounds them by up to 120 ns.
constexpr std::int64_t kTolerance_ns = 1000;

std::vector<DepthPoint> MakePoints(const VioKeyframe& keyframe, const Camera& camera) {
  constexpr double kMaxErrorPx = 3;
  const Rigid3 T_C_W = keyframe.T_W_C.Inverse();
  std::vector<DepthPoint> points;
  for (std::size_t i = 0; i < keyframe.pixels.size(); ++i) {
    const Eigen::Vector3d p_C = T_C_W * keyframe.p_W[i];
    const Eigen::Vector2d& pixel = keyframe.pixels[i];
    const std::optional<Eigen::Vector2d> projected = camera.Project(p_C);
    if (projected && (*projected - pixel).norm() <= kMaxErrorPx && camera.IsInImage(pixel)) {
      points.push_back({static_cast<float>(pixel.x()),
                        static_cast<float>(pixel.y()),
                        static_cast<float>(p_C.norm())});
    }
  }
  return points;
}

}  // namespace

std::size_t AddVioPoints(const std::vector<VioKeyframe>& keyframes,
                         std::vector<PosedImage>* images) {
  std::map<std::int64_t, const VioKeyframe*> by_stamp;
  for (const VioKeyframe& keyframe : keyframes) {
    DEJA_VIEW_CHECK_OP(keyframe.pixels.size(), ==, keyframe.p_W.size());
    by_stamp[keyframe.stamp_ns] = &keyframe;
  }
  std::size_t count = 0;
  for (PosedImage& image : *images) {
    const auto found = by_stamp.lower_bound(image.stamp_ns - kTolerance_ns);
    if (found == by_stamp.end() || found->first > image.stamp_ns + kTolerance_ns) {
      continue;
    }
    const std::vector<DepthPoint> points = MakePoints(*found->second, *image.camera);
    image.points.insert(image.points.end(), points.begin(), points.end());
    count += points.empty() ? 0 : 1;
  }
  return count;
}

}  // namespace deja_view::nerf
