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

TEST(AlignPoints, RejectsTooFewPointsAndSizesThatDiffer) {
  EXPECT_THROW(AlignPoints(RandomPoints(2), RandomPoints(2)), CheckError);
  EXPECT_THROW(AlignPoints(RandomPoints(5), RandomPoints(4)), CheckError);
}

}  // namespace
}  // namespace deja_view
