#include "deja_view/front_end/track_triangulation.hpp"

#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace deja_view {
namespace {

constexpr int kRounds = 3;

std::optional<Eigen::Vector3d> NearestPoint(const std::vector<TrackRay>& rays, double min_depth_m) {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const TrackRay& ray : rays) {
      const double depth = round == 0 ? 1.0 : std::max((p_W - ray.centre_W).norm(), min_depth_m);
      const Eigen::Matrix3d across =
          (Eigen::Matrix3d::Identity() - ray.ray_W * ray.ray_W.transpose()) / (depth * depth);
      A += across;
      b += across * ray.centre_W;
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(A);
    p_W = solver.solve(b);
    if (solver.info() != Eigen::Success || !p_W.allFinite()) {
      return std::nullopt;  // rays that are parallel
    }
  }
  return p_W;
}

}  // namespace

std::vector<std::string> TrackTriangulationOptions::Validate() const {
  Requirements r;
  r.That(min_depth_m > 0, "min_depth_m", min_depth_m, "more than 0 m");
  r.That(max_depth_m > min_depth_m, "max_depth_m", max_depth_m, "more than min_depth_m");
  r.That(max_error_px > 0, "max_error_px", max_error_px, "more than 0 px");
  r.That(pixel_sigma > 0, "pixel_sigma", pixel_sigma, "more than 0 px");
  r.That(max_sigma_ratio > 0, "max_sigma_ratio", max_sigma_ratio, "more than 0");
  return r.errors();
}

std::optional<TriangulatedPoint> TriangulateTrack(const std::vector<TrackRay>& rays,
                                                  double focal_px,
                                                  const TrackTriangulationOptions& options) {
  if (rays.size() < 2) {
    return std::nullopt;
  }
  const auto p_W = NearestPoint(rays, options.min_depth_m);
  if (!p_W) {
    return std::nullopt;
  }
  const Eigen::Vector3d first = (*p_W - rays.front().centre_W).normalized();
  double squared_error = 0;
  double squared_parallax = 0;  // sum over the other rays
  for (const TrackRay& ray : rays) {
    const Eigen::Vector3d to_point = *p_W - ray.centre_W;
    const double depth = to_point.norm();
    if (to_point.dot(ray.ray_W) < options.min_depth_m || depth > options.max_depth_m) {
      return std::nullopt;
    }
    squared_error += to_point.cross(ray.ray_W).squaredNorm() / (depth * depth);
    squared_parallax += (to_point / depth).cross(first).squaredNorm();
  }
  const double rms_px = focal_px * std::sqrt(squared_error / static_cast<double>(rays.size()));
  const double sigma_ratio =
      options.pixel_sigma / std::max(1e-12, focal_px * std::sqrt(squared_parallax));
  if (rms_px > options.max_error_px || sigma_ratio > options.max_sigma_ratio) {
    return std::nullopt;
  }
  return TriangulatedPoint{*p_W, sigma_ratio};
}

}  // namespace deja_view
