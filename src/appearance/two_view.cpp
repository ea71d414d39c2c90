#include "deja_view/appearance/two_view.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/features/hamming_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "epipolar_compat.hpp"
#include <Eigen/Geometry>

namespace deja_view {
namespace {

struct PointPairs {
  std::vector<cv::Point2f> a;
  std::vector<cv::Point2f> b;
};

PointPairs MatchMutually(const Features& a, const Features& b, const TwoViewOptions& options) {
  const auto forward = MatchHamming(a.descriptors, b.descriptors);
  const auto backward = MatchHamming(b.descriptors, a.descriptors);
  PointPairs pairs;
  for (std::size_t i = 0; i < forward.size(); ++i) {
    const HammingMatch& match = forward[i];
    if (match.best < 0 || match.best_distance > options.max_distance ||
        match.best_distance > options.max_ratio * match.second_distance) {
      continue;
    }
    const auto k = static_cast<std::size_t>(match.best);
    if (backward[k].best == static_cast<std::int32_t>(i)) {
      pairs.a.emplace_back(a.keypoints[i].x, a.keypoints[i].y);
      pairs.b.emplace_back(b.keypoints[k].x, b.keypoints[k].y);
    }
  }
  return pairs;
}

/// Points on the plane at distance 1; pairs too far off the axis are left out.
PointPairs Undistort(const PointPairs& pixels, const Camera& camera) {
  constexpr double kMinDepth = 0.17364817766693;  // cos(80 deg)
  PointPairs pairs;
  for (std::size_t i = 0; i < pixels.a.size(); ++i) {
    const Eigen::Vector3d ray_a = camera.Unproject({double{pixels.a[i].x}, double{pixels.a[i].y}});
    const Eigen::Vector3d ray_b = camera.Unproject({double{pixels.b[i].x}, double{pixels.b[i].y}});
    if (std::min(ray_a.z(), ray_b.z()) < kMinDepth) {
      continue;
    }
    const Eigen::Vector2f a = ray_a.hnormalized().cast<float>();
    const Eigen::Vector2f b = ray_b.hnormalized().cast<float>();
    pairs.a.emplace_back(a.x(), a.y());
    pairs.b.emplace_back(b.x(), b.y());
  }
  return pairs;
}

}  // namespace

std::vector<std::string> TwoViewOptions::Validate() const {
  Requirements r;
  r.Range("max_distance", max_distance, 1, 256);
  r.That(max_ratio > 0 && max_ratio <= 1, "max_ratio", max_ratio, "more than 0, at most 1");
  r.That(
      max_error_px > 0 && std::isfinite(max_error_px), "max_error_px", max_error_px, "more than 0");
  r.That(confidence > 0 && confidence < 1, "confidence", confidence, "between 0 and 1");
  r.That(max_iterations >= 1, "max_iterations", max_iterations, "at least 1");
  return r.errors();
}

TwoViewResult CompareTwoViews(const Features& a, const Features& b, const TwoViewOptions& options) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  // With as few points as the estimator samples, all are inliers of anything.
  constexpr std::size_t kMinPairs = 9;
  PointPairs pairs = MatchMutually(a, b, options);
  TwoViewResult result;
  result.matches = static_cast<int>(pairs.a.size());
  if (options.camera != nullptr) {
    pairs = Undistort(pairs, *options.camera);
  }
  if (pairs.a.size() < kMinPairs) {
    return result;
  }
  std::vector<unsigned char> mask;
  if (options.camera != nullptr) {
    internal::FindEssential(pairs.a,
                            pairs.b,
                            options.max_error_px / options.camera->FocalLength(),
                            options.confidence,
                            options.max_iterations,
                            &mask);
  } else {
    internal::FindFundamental(
        pairs.a, pairs.b, options.max_error_px, options.confidence, options.max_iterations, &mask);
  }
  result.inliers = static_cast<int>(
      std::count_if(mask.begin(), mask.end(), [](unsigned char inlier) { return inlier != 0; }));
  return result;
}

}  // namespace deja_view
