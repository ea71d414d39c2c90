#include "deja_view/lab/sim/vio_drift.hpp"

#include <algorithm>
#include <cmath>

#include "small_world.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

class VioDriftTest : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  VioDriftTest()
      : path_(*TinyWorld(), Flight(), GetParam()), drift_(path_, VioOptions(), GetParam()) {}

  static FlightOptions Flight() {
    FlightOptions options = TinyOptions().flight;
    options.duration_s = 60;
    return options;
  }

  FlightPath path_;
  VioDrift drift_;
};

TEST_P(VioDriftTest, StaysWithinTheAskedShareOfThePath) {
  double largest = 0;
  for (double t = 0; t < path_.duration(); t += 0.05) {
    const Eigen::Vector3d truth = drift_.T_V_W() * path_.Pose(t).t;
    largest = std::max(largest, (drift_.Pose(t).t - truth).norm());
  }
  const double share = largest / path_.Length();
  EXPECT_GT(share, 0.9 * VioOptions().drift_min);
  EXPECT_LT(share, 1.1 * VioOptions().drift_max);
  EXPECT_NEAR(share, drift_.drift(), 0.03 * share);
}

TEST_P(VioDriftTest, GravityStaysTrue) {
  double sum = 0;
  int count = 0;
  for (double t = 0; t < path_.duration(); t += 0.5) {
    const Eigen::Vector3d up = drift_.Pose(t).q.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d truth = path_.Pose(t).q.conjugate() * Eigen::Vector3d::UnitZ();
    const double tilt = std::atan2(up.cross(truth).norm(), up.dot(truth));
    EXPECT_LT(tilt, 0.012);
    sum += tilt * tilt;
    ++count;
  }
  const double rms_deg = std::sqrt(sum / count) * 57.29578;
  EXPECT_GT(rms_deg, 0.04);
  EXPECT_LT(rms_deg, 0.35);
}

TEST_P(VioDriftTest, IsSmooth) {
  constexpr double kStep = 0.1;
  for (double t = 0; t + kStep < path_.duration(); t += kStep) {
    const Rigid3 estimated = drift_.Pose(t).Inverse() * drift_.Pose(t + kStep);
    const Rigid3 truth = path_.Pose(t).Inverse() * path_.Pose(t + kStep);
    EXPECT_LT((estimated.t - truth.t).norm(), 0.01);
    EXPECT_LT(RotationAngle(estimated.q.conjugate() * truth.q), 0.004);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, VioDriftTest, ::testing::Values(1, 2, 3, 4));

TEST(VioDrift, ZeroIsTruthInAnotherFrame) {
  const FlightPath path(*TinyWorld(), TinyOptions().flight, 1);
  VioOptions options;
  options.drift_min = options.drift_max = options.tilt_noise_deg = 0;
  const VioDrift drift(path, options, 1);
  EXPECT_LT(drift.Pose(0).t.norm(), 1e-12);
  for (const double t : {0.0, 2.0, 5.0}) {
    const Rigid3 expected = drift.T_V_W() * path.Pose(t);
    EXPECT_LT((drift.Pose(t).t - expected.t).norm(), 1e-9);
    EXPECT_LT(RotationAngle(drift.Pose(t).q.conjugate() * expected.q), 1e-9);
  }
}

}  // namespace
}  // namespace deja_view::sim
