#include "place_policy.hpp"

#include "deja_view/base/angles.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

NearbyPlace At(double x, double yaw_deg) {
  const double yaw = ToRadians(yaw_deg);
  return {0, {x, 0, 0}, {std::cos(yaw), std::sin(yaw), 0}};
}

TEST(PlacePolicy, APlaceIsFarFromOthersOrLooksElsewhere) {
  const PlacePolicy policy(0.5, 30);
  EXPECT_TRUE(policy.IsNewPlace(At(0, 0), {}));
  EXPECT_FALSE(policy.IsNewPlace(At(0, 0), {At(0.49, 29)}));
  EXPECT_TRUE(policy.IsNewPlace(At(0, 0), {At(0.51, 0)}));
  EXPECT_TRUE(policy.IsNewPlace(At(0, 0), {At(0, 31)}));
  EXPECT_FALSE(policy.IsNewPlace(At(0, 0), {At(2, 0), At(0, 90), At(-0.2, -20)}));
}

TEST(PlacePolicy, WithoutSpacingEveryKeyframeIsAPlace) {
  EXPECT_TRUE(PlacePolicy(0, 30).IsNewPlace(At(0, 0), {At(0, 0)}));
}

}  // namespace
}  // namespace deja_view
