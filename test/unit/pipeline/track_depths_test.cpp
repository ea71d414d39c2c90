#include "track_depths.hpp"

#include <cmath>
#include <limits>

#include "keyframe_pair.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::WideCamera;

/// The point as the camera at `T_W_B` sees it, off its pixel by `error_px`.
TrackedPoint Seen(const Eigen::Vector3d& p_W,
                  const Rigid3& T_W_B,
                  std::int64_t id,
                  float error_px = 0) {
  TrackedPoint point;
  point.p_W = p_W;
  point.feature_id = id;
  const auto pixel = WideCamera()->Project((T_W_B * test::ForwardExtrinsic()).Inverse() * p_W);
  point.pixel = pixel.value_or(Eigen::Vector2d::Zero()).cast<float>();
  point.pixel.x() += error_px;
  return point;
}

std::vector<LocatedPoint> Locate(const std::vector<TrackedPoint>& points,
                                 const Rigid3& T_W_B,
                                 TrackDepths* tracks) {
  return tracks->Locate(points, T_W_B, test::ForwardExtrinsic());
}

Rigid3 At(double y) {
  return {FromYaw(0.2), {1, y, 0.5}};
}

TEST(TrackDepths, PutsAPointWhereItsPixelSaysAsFarAsTheVioSays) {
  TrackDepths tracks({}, WideCamera());
  const Eigen::Vector3d p_W(6, 1, 1);
  const auto exact = Locate({Seen(p_W, At(0), 7)}, At(0), &tracks);
  ASSERT_EQ(exact.size(), 1U);
  EXPECT_LT((exact[0].p_B.cast<double>() - At(0).Inverse() * p_W).norm(), 1e-5);
  EXPECT_EQ(exact[0].id, 7);
  // Three pixels beside: turned by three pixels, at the same distance from the camera.
  const auto beside = Locate({Seen(p_W, At(0), 7, 3)}, At(0), &tracks);
  ASSERT_EQ(beside.size(), 1U);
  const Eigen::Vector3d centre_B = test::ForwardExtrinsic().t;
  const Eigen::Vector3d a = exact[0].p_B.cast<double>() - centre_B;
  const Eigen::Vector3d b = beside[0].p_B.cast<double>() - centre_B;
  EXPECT_NEAR(a.norm(), b.norm(), 1e-5);
  EXPECT_NEAR(std::acos(a.dot(b) / (a.norm() * b.norm())), 3 / 458.0, 1e-3);
}

TEST(TrackDepths, LeavesOutWhatDoesNotFit) {
  TrackDepths tracks({}, WideCamera());
  const Eigen::Vector3d ahead(6, 1, 1);
  TrackedPoint nowhere = Seen(ahead, At(0), 1);
  nowhere.p_W.x() = std::numeric_limits<double>::quiet_NaN();
  TrackedPoint no_pixel = Seen(ahead, At(0), 2);
  no_pixel.pixel.y() = std::numeric_limits<float>::infinity();
  const Eigen::Vector3d behind(-6, 1, 1);
  const Eigen::Vector3d far(80, 10, 1);
  EXPECT_THAT(Locate({nowhere,
                      no_pixel,
                      Seen(behind, At(0), 3),
                      Seen(far, At(0), 4),
                      Seen(ahead, At(0), 5, 4.5F)},
                     At(0),
                     &tracks),
              testing::IsEmpty());
  EXPECT_EQ(Locate({Seen(ahead, At(0), 5, 3.5F)}, At(0), &tracks).size(), 1U);
}

TEST(TrackDepths, ParallaxOverTheTrackMakesDepthCertain) {
  TrackDepthOptions options;
  options.sigma_floor = 0.001;
  TrackDepths tracks(options, WideCamera());
  const Eigen::Vector3d p_W(7, 1.5, 0.6);
  double last = 0;
  for (int i = 0; i < 4; ++i) {
    const Rigid3 T_W_B = At(0.1 * i);
    const auto located = Locate({Seen(p_W, T_W_B, 1)}, T_W_B, &tracks);
    ASSERT_EQ(located.size(), 1U);
    const Eigen::Vector3d first = (At(0) * test::ForwardExtrinsic()).t;
    const Eigen::Vector3d now = (T_W_B * test::ForwardExtrinsic()).t;
    const double depth = (p_W - now).norm();
    if (i == 0) {
      EXPECT_NEAR(located[0].depth_sigma, options.sigma_max * depth, 1e-6) << "not moved yet";
    } else {
      // One pixel against the base line across the ray.
      const Eigen::Vector3d ray = (p_W - now) / depth;
      const Eigen::Vector3d base = first - now;
      const double parallax = (base - base.dot(ray) * ray).norm() / depth;
      EXPECT_NEAR(located[0].depth_sigma / depth, std::hypot(0.001, 1.0 / (458 * parallax)), 1e-6);
      EXPECT_LT(located[0].depth_sigma, last);
    }
    last = located[0].depth_sigma;
  }
}

TEST(TrackDepths, ATrackEndsWhereItIsNotSeen) {
  const Eigen::Vector3d p_W(7, 1.5, 0.6);
  const auto sigma_after = [&](bool is_missed, bool is_cleared) {
    TrackDepths tracks({}, WideCamera());
    Locate({Seen(p_W, At(0), 1)}, At(0), &tracks);
    if (is_missed) {
      Locate({}, At(0.2), &tracks);
    }
    if (is_cleared) {
      tracks.Clear();
    }
    return Locate({Seen(p_W, At(0.4), 1)}, At(0.4), &tracks).at(0).depth_sigma;
  };
  const float tracked = sigma_after(false, false);
  EXPECT_LT(tracked, 0.5F * sigma_after(true, false));
  EXPECT_LT(tracked, 0.5F * sigma_after(false, true));
}

}  // namespace
}  // namespace deja_view
