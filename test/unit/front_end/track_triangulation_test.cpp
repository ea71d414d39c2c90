#include "deja_view/front_end/track_triangulation.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr double kFocalPx = 400;

std::vector<TrackRay> RaysTo(const Eigen::Vector3d& p_W,
                             const std::vector<Eigen::Vector3d>& centres) {
  std::vector<TrackRay> rays;
  rays.reserve(centres.size());
  for (const Eigen::Vector3d& centre : centres) {
    rays.push_back({centre, (p_W - centre).normalized()});
  }
  return rays;
}

TEST(TriangulateTrack, FindsThePointAndItsUncertainty) {
  const Eigen::Vector3d p_W(0.3, -0.2, 4);
  const auto rays = RaysTo(p_W, {{0, 0, 0}, {0.5, 0, 0}});
  const auto point = TriangulateTrack(rays, kFocalPx, {});
  ASSERT_TRUE(point);
  EXPECT_LT((point->p_W - p_W).norm(), 1e-9);
  // One pixel over the parallax angle between the two rays.
  const double sine = rays[0].ray_W.cross(rays[1].ray_W).norm();
  EXPECT_NEAR(point->sigma_ratio, 1.0 / (kFocalPx * sine), 1e-9);
  EXPECT_NEAR(point->sigma_ratio, 0.02, 0.001);
}

TEST(TriangulateTrack, MoreRaysAreMoreCertain) {
  const Eigen::Vector3d p_W(0, 0, 4);
  const auto two = TriangulateTrack(RaysTo(p_W, {{0, 0, 0}, {0.4, 0, 0}}), kFocalPx, {});
  const auto three =
      TriangulateTrack(RaysTo(p_W, {{0, 0, 0}, {0.4, 0, 0}, {-0.4, 0, 0}}), kFocalPx, {});
  ASSERT_TRUE(two && three);
  EXPECT_NEAR(three->sigma_ratio, two->sigma_ratio / std::sqrt(2.0), 1e-9);
}

TEST(TriangulateTrack, RefusesWhatSaysTooLittle) {
  const Eigen::Vector3d p_W(0, 0, 4);
  EXPECT_FALSE(TriangulateTrack({}, kFocalPx, {}));
  EXPECT_FALSE(TriangulateTrack(RaysTo(p_W, {{0, 0, 0}}), kFocalPx, {}));
  // A centimetre of baseline; the same place twice.
  EXPECT_FALSE(TriangulateTrack(RaysTo(p_W, {{0, 0, 0}, {0.01, 0, 0}}), kFocalPx, {}));
  EXPECT_FALSE(TriangulateTrack(RaysTo(p_W, {{0, 0, 0}, {0, 0, 0}}), kFocalPx, {}));
  // Straight ahead.
  EXPECT_FALSE(TriangulateTrack(RaysTo(p_W, {{0, 0, 0}, {0, 0, 1}}), kFocalPx, {}));
}

TEST(TriangulateTrack, RefusesRaysThatDoNotMeetOrMeetBehindTheCameras) {
  const Eigen::Vector3d p_W(0, 0, 4);
  auto rays = RaysTo(p_W, {{0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0}});
  ASSERT_TRUE(TriangulateTrack(rays, kFocalPx, {}));
  rays[2].ray_W = (Eigen::Vector3d(0.2, 0, 4) - rays[2].centre_W).normalized();  // 20 px off
  EXPECT_FALSE(TriangulateTrack(rays, kFocalPx, {}));
  auto behind = RaysTo(p_W, {{0, 0, 0}, {0.5, 0, 0}});
  for (TrackRay& ray : behind) {
    ray.ray_W = -ray.ray_W;
  }
  EXPECT_FALSE(TriangulateTrack(behind, kFocalPx, {}));
  EXPECT_FALSE(TriangulateTrack(RaysTo({0, 0, 70}, {{0, 0, 0}, {20, 0, 0}}), kFocalPx, {}));
}

}  // namespace
}  // namespace deja_view
