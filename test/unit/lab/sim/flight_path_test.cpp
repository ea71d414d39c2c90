#include "deja_view/lab/sim/flight_path.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

#include "small_world.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

class FlightPathTest : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  static FlightOptions Options() {
    FlightOptions options = MakePreset("small").flight;
    options.duration_s = 60;
    return options;
  }
};

TEST_P(FlightPathTest, KeepsItsLimits) {
  const FlightOptions options = Options();
  const FlightPath path(*TinyWorld(), options, GetParam());
  double fastest = 0;
  for (double t = 0; t <= path.duration(); t += 0.01) {
    EXPECT_GE(TinyWorld()->Clearance(path.Pose(t).t), options.clearance_m - 1e-3);
    EXPECT_LT(path.AngularVelocity(t).norm(), 1.0);
    EXPECT_LT(path.Acceleration(t).norm(), 3.0);
    fastest = std::max(fastest, path.Velocity(t).norm());
  }
  EXPECT_GT(fastest, 0.6);
  EXPECT_LT(fastest, 1.65);
  EXPECT_LT(path.Velocity(0.1).norm(), 1e-6);
  EXPECT_GT(path.Length(), 25);
}

TEST_P(FlightPathTest, DerivativesMatchDifferences) {
  const FlightPath path(*TinyWorld(), Options(), GetParam());
  constexpr double kDelta = 1e-4;
  for (double t = 1; t < 59; t += 1.7) {
    const Eigen::Vector3d velocity =
        (path.Pose(t + kDelta).t - path.Pose(t - kDelta).t) / (2 * kDelta);
    EXPECT_LT((velocity - path.Velocity(t)).norm(), 1e-6);
    const Eigen::Vector3d acceleration =
        (path.Velocity(t + kDelta) - path.Velocity(t - kDelta)) / (2 * kDelta);
    EXPECT_LT((acceleration - path.Acceleration(t)).norm(), 1e-6);
  }
}

TEST_P(FlightPathTest, RevisitsFromTheSameAndFromOtherViewpoints) {
  const FlightPath path(*TinyWorld(), Options(), GetParam());
  const Eigen::Vector3d ahead = SimulatedExtrinsic().q * Eigen::Vector3d::UnitZ();
  int same = 0;
  int other = 0;
  for (double t = 12; t < 60; t += 0.5) {
    double nearest_angle = 10;
    double nearest = 10;
    for (double s = 0; s < t - 10; s += 0.25) {
      const double distance = (path.Pose(t).t - path.Pose(s).t).norm();
      if (distance < nearest) {
        nearest = distance;
        nearest_angle =
            std::acos(std::clamp((path.Pose(t).q * ahead).dot(path.Pose(s).q * ahead), -1.0, 1.0));
      }
    }
    same += nearest < 0.35 && nearest_angle < 0.2 ? 1 : 0;
    other += nearest > 0.25 && nearest < 1.5 && nearest_angle > 0.2 && nearest_angle < 0.9 ? 1 : 0;
  }
  EXPECT_GE(same, 8);
  EXPECT_GE(other, 3);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FlightPathTest, ::testing::Values(1, 2, 3));

TEST(FlightPath, HoversUprightWithXUp) {
  const FlightPath path(*TinyWorld(), TinyOptions().flight, 1);
  const Rigid3 T_W_B = path.Pose(0);
  // The body's x axis points up but for the mount's 0.17 rad.
  EXPECT_NEAR((T_W_B.q * Eigen::Vector3d::UnitX()).z(), std::cos(0.17), 1e-9);
  EXPECT_LT((T_W_B.q * Eigen::Vector3d::UnitZ()).z(), 0);  // looks down a little
  EXPECT_NEAR((T_W_B.q * Eigen::Vector3d::UnitY()).z(), 0, 1e-9);
}

TEST(FlightPath, GroundTruthIsEvenlyStamped) {
  const FlightPath path(*TinyWorld(), TinyOptions().flight, 1);
  const Trajectory truth = path.GroundTruth(1000);
  ASSERT_EQ(truth.size(), 6U * 200 + 1);
  EXPECT_EQ(truth.stamps_ns[0], 1000);
  EXPECT_EQ(truth.stamps_ns[200], 1000 + 1000000000);
  EXPECT_LT((truth.poses[200].t - path.Pose(1.0).t).norm(), 1e-12);
}

TEST(FlightPath, SaysWhenThereIsNoWay) {
  FlightOptions options = TinyOptions().flight;
  options.clearance_m = 3.0;
  EXPECT_THROW(FlightPath(*TinyWorld(), options, 1), InputError);
}

}  // namespace
}  // namespace deja_view::sim
