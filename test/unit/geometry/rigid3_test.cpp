#include "deja_view/geometry/rigid3.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr double kPi = 3.14159265358979323846;

Eigen::Vector3d RandomVector(std::mt19937& rng, double range) {
  std::uniform_real_distribution<double> uniform(-range, range);
  return {uniform(rng), uniform(rng), uniform(rng)};
}

TEST(Rigid3, InnerLettersCancel) {
  std::mt19937 rng(1);
  for (int i = 0; i < 100; ++i) {
    const Rigid3 T_A_B{ExpSo3(RandomVector(rng, 2.0)), RandomVector(rng, 5.0)};
    const Rigid3 T_B_C{ExpSo3(RandomVector(rng, 2.0)), RandomVector(rng, 5.0)};
    const Eigen::Vector3d p_C = RandomVector(rng, 5.0);
    EXPECT_LT(((T_A_B * T_B_C) * p_C - T_A_B * (T_B_C * p_C)).norm(), 1e-12);
    EXPECT_LT((T_A_B.Inverse() * (T_A_B * p_C) - p_C).norm(), 1e-12);
  }
}

TEST(Rigid3, ExpAndLogAreInverse) {
  std::mt19937 rng(2);
  for (const double range : {1e-12, 1e-6, 1e-3, 0.5, 1.7}) {
    const Eigen::Vector3d w = RandomVector(rng, range);
    EXPECT_LT((LogSo3(ExpSo3(w)) - w).norm(), 1e-14 + 1e-10 * w.norm());
    EXPECT_NEAR(RotationAngle(ExpSo3(w)), w.norm(), 1e-14 + 1e-10 * w.norm());
  }
  const Eigen::Quaterniond q = ExpSo3({0.3, -0.2, 0.1});
  EXPECT_LT((LogSo3(Eigen::Quaterniond(-q.coeffs())) - LogSo3(q)).norm(), 1e-14);
}

TEST(Rigid3, YawIsTheOuterAngleOfZyx) {
  const Eigen::Quaterniond q = FromYaw(2.5) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(-0.7, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(Yaw(q), 2.5, 1e-12);
}

TEST(Rigid3, WrapsAngles) {
  EXPECT_NEAR(WrapAngle(kPi + 0.1), -kPi + 0.1, 1e-12);
  EXPECT_NEAR(WrapAngle(-7 * kPi - 0.1), kPi - 0.1, 1e-12);
  EXPECT_EQ(WrapAngle(0.0), 0.0);
}

TEST(Rigid3, YawTransformIsTheNearestRotationAboutZ) {
  const Rigid3 T{FromYaw(-1.1) * ExpSo3({0.02, -0.03, 0.0}), {1, 2, 3}};
  const double best = ToYawTransform(T).yaw;
  const auto distance = [&](double yaw) {
    return (FromYaw(yaw).toRotationMatrix() - T.R()).norm();
  };
  EXPECT_LT(distance(best), distance(best + 1e-4));
  EXPECT_LT(distance(best), distance(best - 1e-4));
  EXPECT_NEAR(best, -1.1, 1e-3);
}

TEST(Rigid3, InterpolatesToBothEnds) {
  const Rigid3 a{FromYaw(0.0), {0, 0, 0}};
  const Rigid3 b{FromYaw(1.0), {2, 0, 0}};
  EXPECT_NEAR(Yaw(Interpolate(a, b, 0.25).q), 0.25, 1e-12);
  EXPECT_NEAR(Interpolate(a, b, 0.25).t.x(), 0.5, 1e-12);
  EXPECT_NEAR(Yaw(Interpolate(a, b, 1.0).q), 1.0, 1e-12);
}

TEST(Rigid3, SkewIsTheCrossProduct) {
  const Eigen::Vector3d w(1, 2, 3);
  const Eigen::Vector3d v(-4, 5, 0.5);
  EXPECT_LT((Skew(w) * v - w.cross(v)).norm(), 1e-15);
}

TEST(NearestRotation, ProjectsRoundedMatricesAndRefusesOthers) {
  const Eigen::Quaterniond q = ExpSo3({0.3, -0.7, 1.1});
  Eigen::Matrix3d rounded = q.toRotationMatrix();
  rounded(0, 1) += 4e-4;
  const auto nearest = NearestRotation(rounded, 1e-3);
  ASSERT_TRUE(nearest.has_value());
  EXPECT_LT(RotationAngle(nearest->conjugate() * q), 4e-4);
  EXPECT_FALSE(NearestRotation(rounded, 1e-4).has_value());
  EXPECT_FALSE(NearestRotation(-Eigen::Matrix3d::Identity(), 1e-3).has_value());
  EXPECT_FALSE(NearestRotation(2 * Eigen::Matrix3d::Identity(), 1e-3).has_value());
  rounded(2, 2) = std::nan("");
  EXPECT_FALSE(NearestRotation(rounded, 1e9).has_value());
}

}  // namespace
}  // namespace deja_view
