#include "own_points.hpp"

#include <algorithm>
#include <vector>

namespace deja_view {

void ReplaceOwnPoints(const CornerView& view,
                      const Camera& camera,
                      const MotionStereoOptions& options,
                      KeyframeFeatures* features) {
  KeyframeFeatures& f = *features;
  const auto first_own = std::find(f.point_ids.begin(), f.point_ids.end(), kOwnPoint);
  const auto tracked = static_cast<std::size_t>(first_own - f.point_ids.begin());
  f.points_B.resize(tracked);
  f.point_pixels.resize(tracked);
  f.point_depth_sigmas.resize(tracked);
  f.point_ids.resize(tracked);
  f.point_descriptors.resize(tracked);
  if (tracked >= static_cast<std::size_t>(options.enough)) {
    return;
  }
  for (const std::size_t i : SelectPoints(view, f.point_pixels, camera, options)) {
    const InverseDepth& depth = view.depths[i];
    f.points_B.push_back((f.T_B_C * (view.rays[i].cast<double>() / depth.mean)).cast<float>());
    f.point_pixels.push_back(view.pixels[i]);
    f.point_depth_sigmas.push_back(depth.sigma / (depth.mean * depth.mean));
    f.point_ids.push_back(kOwnPoint);
    f.point_descriptors.push_back(view.descriptors[i]);
  }
}

double MedianDepth(const KeyframeFeatures& features) {
  constexpr std::size_t kEnough = 10;
  constexpr double kRoomM = 4.0;
  std::vector<double> depths;
  for (const Eigen::Vector3f& p_B : features.points_B) {
    depths.push_back((p_B.cast<double>() - features.T_B_C.t).norm());
  }
  if (depths.size() < kEnough) {
    return kRoomM;
  }
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

}  // namespace deja_view
