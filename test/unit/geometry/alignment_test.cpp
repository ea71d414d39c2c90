#include "deja_view/geometry/alignment.hpp"

#include "deja_view/base/check.hpp"

#include <random>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

std::vector<Eigen::Vector3d> RandomPoints(int count) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> uniform(-5, 5);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(uniform(rng), uniform(rng), uniform(rng));
  }
  return points;
}

TEST(AlignPoints, RecoversASimilarity) {
  const Similarity3 truth{2.5, {ExpSo3({0.3, -1.0, 2.0}), {1, -2, 3}}};
  const auto p_B = RandomPoints(20);
  std::vector<Eigen::Vector3d> p_A;
  for (const auto& p : p_B) {
    p_A.push_back(truth * p);
  }
  const Similarity3 found = AlignPoints(p_A, p_B, true);
  EXPECT_NEAR(found.scale, 2.5, 1e-12);
  EXPECT_LT(RotationAngle(found.T_A_B.q.conjugate() * truth.T_A_B.q), 1e-12);
  EXPECT_LT((found.T_A_B.t - truth.T_A_B.t).norm(), 1e-12);
}

TEST(Similarity3, InverseTakesPointsBack) {
  const Similarity3 A_B{2.5, {ExpSo3({0.3, -1.0, 2.0}), {1, -2, 3}}};
  for (const Eigen::Vector3d& p : RandomPoints(5)) {
    EXPECT_LT((A_B.Inverse() * (A_B * p) - p).norm(), 1e-12);
  }
}

TEST(AlignPoints, KeepsScaleOneWhenAsked) {
  const auto p_B = RandomPoints(20);
  std::vector<Eigen::Vector3d> p_A;
  for (const auto& p : p_B) {
    p_A.push_back(2.0 * p);
  }
  const Similarity3 found = AlignPoints(p_A, p_B, false);
  EXPECT_EQ(found.scale, 1.0);
  EXPECT_LT(RotationAngle(found.T_A_B.q), 1e-9);
}

TEST(AlignYaw, TurnsAboutTheVerticalAlone) {
  const Rigid3 truth{FromYaw(2.0), {1, -2, 3}};
  const auto p_B = RandomPoints(6);
  std::vector<Eigen::Vector3d> p_A;
  for (const auto& p : p_B) {
    p_A.push_back(truth * p);
  }
  const Rigid3 found = AlignYaw(p_A, p_B);
  EXPECT_LT((found.t - truth.t).norm(), 1e-12);
  EXPECT_LT(RotationAngle(found.q.conjugate() * truth.q), 1e-12);
  // What tilts them is not made good.
  for (auto& p : p_A) {
    p = ExpSo3({0.1, 0, 0}) * p;
  }
  const Rigid3 level = AlignYaw(p_A, p_B);
  EXPECT_LT((level.q * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_THROW(AlignYaw(p_A, RandomPoints(5)), CheckError);
  EXPECT_THROW(AlignYaw({}, {}), CheckError);
}

TEST(AlignPoints, RejectsTooFewPointsAndSizesThatDiffer) {
  EXPECT_THROW(AlignPoints(RandomPoints(2), RandomPoints(2)), CheckError);
  EXPECT_THROW(AlignPoints(RandomPoints(5), RandomPoints(4)), CheckError);
}

}  // namespace
}  // namespace deja_view
