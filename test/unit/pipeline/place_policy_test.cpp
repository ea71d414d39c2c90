#include "place_policy.hpp"

#include "deja_view/base/angles.hpp"

#include "keyframe_pair.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

/// The camera looks along x, turned by `yaw_deg`.
NearbyPlace LookingFrom(const Eigen::Vector3d& position, double yaw_deg = 0) {
  return {0, {FromYaw(ToRadians(yaw_deg)) * test::ForwardExtrinsic().q, position}};
}
NearbyPlace LookingFrom(double x, double yaw_deg) {
  return LookingFrom(Eigen::Vector3d(x, 0, 0), yaw_deg);
}

/// A wall at `depth_m` ahead that fills the image, or nothing.
KeyframeFeatures Wall(double depth_m) {
  KeyframeFeatures seen;
  seen.T_B_C = test::ForwardExtrinsic();
  for (double v = 12; v < 480 && depth_m > 0; v += 24) {
    for (double u = 12; u < 752; u += 24) {
      const Eigen::Vector3d ray = test::WideCamera()->Unproject({u, v});
      seen.points_B.push_back((seen.T_B_C * (depth_m / ray.z() * ray)).cast<float>());
    }
  }
  return seen;
}

PlacePolicy Spaced(double spacing_m) {
  return {spacing_m, 30, PlaceCoverOptions{}, test::WideCamera()};
}

/// Whether a wall at `depth_m` is a new place where there is one at `other`.
bool IsNew(double depth_m, const NearbyPlace& other, const PlaceCoverOptions& cover = {}) {
  const PlacePolicy policy(-1, 30, cover, test::WideCamera());
  return policy.IsNewPlace(LookingFrom(0, 0), Wall(depth_m), {LookingFrom(50, 0), other});
}

TEST(PlacePolicy, WithASpacingAPlaceIsFarFromOthersOrLooksElsewhere) {
  const PlacePolicy policy = Spaced(0.5);
  const KeyframeFeatures nothing;
  EXPECT_TRUE(policy.IsNewPlace(LookingFrom(0, 0), nothing, {}));
  EXPECT_FALSE(policy.IsNewPlace(LookingFrom(0, 0), nothing, {LookingFrom(0.49, 29)}));
  EXPECT_TRUE(policy.IsNewPlace(LookingFrom(0, 0), nothing, {LookingFrom(0.51, 0)}));
  EXPECT_TRUE(policy.IsNewPlace(LookingFrom(0, 0), nothing, {LookingFrom(0, 31)}));
  EXPECT_FALSE(policy.IsNewPlace(
      LookingFrom(0, 0), nothing, {LookingFrom(2, 0), LookingFrom(0, 90), LookingFrom(-0.2, -20)}));
}

TEST(PlacePolicy, WithASpacingOfZeroEveryKeyframeIsAPlace) {
  EXPECT_TRUE(Spaced(0).IsNewPlace(LookingFrom(0, 0), KeyframeFeatures{}, {LookingFrom(0, 0)}));
}

TEST(PlacePolicy, SidewaysItIsTheAngleThatCounts) {
  PlaceCoverOptions cover;
  cover.max_angle_deg = 8;
  // A wall seen from 8 degrees beside: at 5 m that is 0.70 m, at 1 m 0.14 m. Towards the image's
  // edge the angle is smaller.
  for (const double depth : {1.0, 5.0}) {
    EXPECT_FALSE(IsNew(depth, LookingFrom({0, 0.11 * depth, 0}), cover)) << depth;
    EXPECT_TRUE(IsNew(depth, LookingFrom({0, 0.17 * depth, 0}), cover)) << depth;
  }
}

TEST(PlacePolicy, AheadItIsTheScaleThatCounts) {
  PlaceCoverOptions cover;
  cover.max_scale = 1.25;
  cover.min_share = 0.5;
  for (const double depth : {1.0, 5.0}) {
    EXPECT_FALSE(IsNew(depth, LookingFrom({0.18 * depth, 0, 0}), cover)) << depth;
    EXPECT_TRUE(IsNew(depth, LookingFrom({0.22 * depth, 0, 0}), cover)) << depth;
    EXPECT_FALSE(IsNew(depth, LookingFrom({-0.22 * depth, 0, 0}), cover)) << depth;
    EXPECT_TRUE(IsNew(depth, LookingFrom({-0.4 * depth, 0, 0}), cover)) << depth;
  }
}

TEST(PlacePolicy, TurnedItIsTheImageThatCounts) {
  // The image is 78 degrees wide; its middle 60 % span 52 degrees.
  PlaceCoverOptions cover;
  cover.min_share = 0.6;
  EXPECT_FALSE(IsNew(3, LookingFrom(0, 20), cover));
  EXPECT_TRUE(IsNew(3, LookingFrom(0, 40), cover));
  EXPECT_TRUE(IsNew(3, LookingFrom(0, 180), cover));
  cover.min_share = 0.3;
  EXPECT_FALSE(IsNew(3, LookingFrom(0, 40), cover));
}

TEST(PlacePolicy, ASinglePlaceMustCoverEnough) {
  PlaceCoverOptions cover;
  cover.min_share = 0.6;
  const PlacePolicy policy(-1, 30, cover, test::WideCamera());
  EXPECT_TRUE(
      policy.IsNewPlace(LookingFrom(0, 0), Wall(3), {LookingFrom(0, 40), LookingFrom(0, -40)}));
}

TEST(PlacePolicy, WithoutPointsAGridStandsForThem) {
  EXPECT_FALSE(IsNew(0, LookingFrom(0, 0)));
  EXPECT_TRUE(IsNew(0, LookingFrom(0, 50)));
  EXPECT_TRUE(IsNew(0, LookingFrom({0, 1.0, 0})));
  KeyframeFeatures few = Wall(1.0);
  few.points_B.resize(10);
  const PlacePolicy policy(-1, 30, PlaceCoverOptions{}, test::WideCamera());
  EXPECT_FALSE(
      policy.IsNewPlace(LookingFrom(0, 0), KeyframeFeatures{}, {LookingFrom({0, 0.3, 0})}));
  EXPECT_TRUE(policy.IsNewPlace(LookingFrom(0, 0), few, {LookingFrom({0, 0.3, 0})}))
      << "as near as the few are";
}

}  // namespace
}  // namespace deja_view
