#include "deja_view/host/world_level.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/host/host_kind.hpp"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

// A camera that looks ahead and a little down while its drone yaws to and fro and sways.
Rigid3 CameraAt(int image, double yaw_deg, double roll_deg) {
  const double phase = 0.05 * image;
  const Eigen::AngleAxisd yaw(ToRadians(yaw_deg) * std::sin(phase), Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd roll(ToRadians(roll_deg) * std::sin(3.1 * phase),
                               Eigen::Vector3d::UnitX());
  Eigen::Matrix3d R_B_C;  // columns: right, down, ahead
  R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::AngleAxisd down(ToRadians(-10.0), Eigen::Vector3d::UnitX());
  Rigid3 T_W_C;
  T_W_C.q = yaw * roll * Eigen::Quaterniond(R_B_C) * down;
  return T_W_C;
}

void Fly(const Rigid3& T_N_W, double yaw_deg, WorldLevel* level) {
  for (int i = 0; i < 400; ++i) {
    level->Add(T_N_W * CameraAt(i, yaw_deg, 8));
  }
}

Rigid3 Tilted(double angle_deg) {
  return {Eigen::Quaterniond(
              Eigen::AngleAxisd(ToRadians(angle_deg), Eigen::Vector3d(0.6, 0.8, 0).normalized())),
          Eigen::Vector3d::Zero()};
}

TEST(WorldLevel, LeavesALevelWorldAsItIs) {
  WorldLevel level(GravityPolicy::kGiven);
  Fly(Rigid3::Identity(), 170, &level);
  EXPECT_EQ(level.T_L_W()->q.angularDistance(Eigen::Quaterniond::Identity()), 0);
}

TEST(WorldLevel, RefusesAWorldThatIsNotAndSaysWhatHelps) {
  for (const double angle_deg : {60.0, 90.0, 180.0}) {
    WorldLevel level(GravityPolicy::kGiven);
    try {
      Fly(Tilted(angle_deg), 170, &level);
      FAIL() << angle_deg;
    } catch (const UnusableFlight& error) {
      EXPECT_THAT(error.what(), HasSubstr("expected z up"));
      EXPECT_THAT(error.what(), HasSubstr("gravity: estimate"));
    }
  }
}

TEST(WorldLevel, FindsUpWhateverTheWorld) {
  for (const double angle_deg : {0.0, 35.0, 90.0, 180.0}) {
    WorldLevel level(GravityPolicy::kEstimate);
    EXPECT_FALSE(level.T_L_W());
    const Rigid3 T_N_W = Tilted(angle_deg);
    Fly(T_N_W, 170, &level);
    ASSERT_TRUE(level.T_L_W());
    const Eigen::Vector3d up_L = level.T_L_W()->q * (T_N_W.q * Eigen::Vector3d::UnitZ());
    EXPECT_LT(ToDegrees(std::acos(std::min(1.0, up_L.z()))), 6) << angle_deg;
  }
}

TEST(WorldLevel, SaysNothingOfACameraThatHardlyTurns) {
  WorldLevel given(GravityPolicy::kGiven);
  Fly(Tilted(90), 15, &given);
  EXPECT_TRUE(given.T_L_W());
  WorldLevel estimated(GravityPolicy::kEstimate);
  Fly(Tilted(90), 15, &estimated);
  EXPECT_FALSE(estimated.T_L_W());
}

TEST(CheckGravity, EstimatesOfPosesAloneOnly) {
  EXPECT_NO_THROW(CheckGravity(HostKind::kOdometry, GravityPolicy::kEstimate, "--gravity"));
  EXPECT_NO_THROW(CheckGravity(HostKind::kVinsMono, GravityPolicy::kGiven, "--gravity"));
  EXPECT_THROW(CheckGravity(HostKind::kVinsMono, GravityPolicy::kEstimate, "--gravity"),
               InputError);
}

}  // namespace
}  // namespace deja_view
