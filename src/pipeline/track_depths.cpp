#include "track_depths.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view {

std::optional<Eigen::Vector3d> TrackDepths::InCamera(const TrackedPoint& point,
                                                     const Rigid3& T_C_W) const {
  if (!point.p_W.allFinite() || !point.pixel.allFinite()) {
    return std::nullopt;
  }
  const Eigen::Vector3d p_C = T_C_W * point.p_W;
  const Eigen::Vector2d pixel = point.pixel.cast<double>();
  const auto reprojected = camera_->Project(p_C);
  if (p_C.norm() > options_.max_depth_m || !camera_->IsInImage(pixel) || !reprojected ||
      (*reprojected - pixel).norm() > options_.max_error_px) {
    return std::nullopt;
  }
  return p_C.norm() * camera_->Unproject(pixel);
}

double TrackDepths::DepthSigma(const Eigen::Vector3d& p_W,
                               const Eigen::Vector3d& first_W,
                               const Eigen::Vector3d& centre_W) const {
  const Eigen::Vector3d ray = p_W - centre_W;
  const double depth = std::max(1e-3, ray.norm());
  const double parallax = (first_W - centre_W).cross(ray).norm() / (depth * depth);
  const double ratio =
      std::hypot(options_.sigma_floor,
                 options_.track_sigma_px / (camera_->FocalLength() * std::max(1e-6, parallax)));
  return depth * std::min(options_.sigma_max, ratio);
}

std::vector<LocatedPoint> TrackDepths::Locate(const std::vector<TrackedPoint>& points,
                                              const Rigid3& T_W_B,
                                              const Rigid3& T_B_C) {
  const Rigid3 T_W_C = T_W_B * T_B_C;
  const Rigid3 T_C_W = T_W_C.Inverse();
  std::unordered_map<std::int64_t, Eigen::Vector3d> seen_now;
  std::vector<LocatedPoint> located;
  for (const TrackedPoint& point : points) {
    const auto p_C = InCamera(point, T_C_W);
    if (!p_C) {
      continue;
    }
    const auto before = first_centres_W_.find(point.feature_id);
    const Eigen::Vector3d& first_W = before != first_centres_W_.end() ? before->second : T_W_C.t;
    seen_now.try_emplace(point.feature_id, first_W);
    located.push_back({(T_B_C * *p_C).cast<float>(),
                       point.pixel,
                       static_cast<float>(DepthSigma(point.p_W, first_W, T_W_C.t)),
                       point.feature_id});
  }
  first_centres_W_ = std::move(seen_now);
  return located;
}

}  // namespace deja_view
