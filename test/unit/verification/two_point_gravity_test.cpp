#include "deja_view/verification/relative_pose.hpp"

#include <random>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

class TwoPointGravity : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(TwoPointGravity, FindsThePoseOfARig) {
  std::mt19937 rng(GetParam());
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto random = [&](double range) {
    return Eigen::Vector3d(range * uniform(rng), range * uniform(rng), range * uniform(rng));
  };
  const YawTransform truth{3.0 * uniform(rng), random(2.0)};
  const Rigid3 T = truth.ToRigid3();
  std::array<GravityAlignedPoint, 2> points;
  for (auto& point : points) {
    point.point = random(5.0);
    point.centre = random(0.3);
    point.bearing = (T * point.point - point.centre).normalized();
  }
  const auto solutions = SolveTwoPointGravityPose(points[0], points[1]);
  ASSERT_FALSE(solutions.empty());
  double best = 1e9;
  for (const auto& solution : solutions) {
    best = std::min(best,
                    (solution.t - truth.t).norm() + std::abs(WrapAngle(solution.yaw - truth.yaw)));
  }
  EXPECT_LT(best, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TwoPointGravity, ::testing::Range(1U, 40U));

TEST(TwoPointGravityDegenerate, SaysNothingForLevelBearings) {
  const GravityAlignedPoint a{{1, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  const GravityAlignedPoint b{{0, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  EXPECT_TRUE(SolveTwoPointGravityPose(a, b).empty());
}

TEST(TwoPointGravityDegenerate, RejectsPointsBehindTheCamera) {
  // Both points would have to lie against their bearings.
  const GravityAlignedPoint a{{1, 0, 2}, {-0.4, 0, -0.9165}, {0, 0, 0}};
  const GravityAlignedPoint b{{0, 1, -2}, {0, -0.4, 0.9165}, {0, 0, 0}};
  for (const auto& solution : SolveTwoPointGravityPose(a, b)) {
    EXPECT_GT((solution.ToRigid3() * a.point - a.centre).dot(a.bearing), 0);
    EXPECT_GT((solution.ToRigid3() * b.point - b.centre).dot(b.bearing), 0);
  }
}

}  // namespace
}  // namespace deja_view
