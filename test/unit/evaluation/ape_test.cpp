#include "deja_view/evaluation/ape.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

using Points = std::vector<Eigen::Vector3d>;

TEST(ComputeApe, IsZeroForAMovedCopy) {
  const Points truth = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 3}};
  const Rigid3 T{ExpSo3({0.4, -0.3, 1.2}), {3, -2, 1}};
  Points estimate;
  for (const auto& p : truth) {
    estimate.push_back(T * p);
  }
  const ApeStatistics ape = ComputeApe(truth, estimate);
  EXPECT_LT(ape.max, 1e-12);
  EXPECT_LT((ape.T_truth_estimate.t - T.Inverse().t).norm(), 1e-12);
}

TEST(ComputeApeUnaligned, GivesTheStatisticsOfTheDistances) {
  // Distances 1, 2, 3 and 6: mean 3, median 2.5, rmse sqrt(50 / 4).
  const Points truth = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const Points estimate = {{1, 0, 0}, {0, 2, 0}, {0, 0, -3}, {2, 4, 4}};
  const ApeStatistics ape = ComputeApeUnaligned(truth, estimate);
  EXPECT_DOUBLE_EQ(ape.max, 6);
  EXPECT_DOUBLE_EQ(ape.min, 1);
  EXPECT_DOUBLE_EQ(ape.mean, 3);
  EXPECT_DOUBLE_EQ(ape.median, 2.5);
  EXPECT_DOUBLE_EQ(ape.rmse, std::sqrt(50.0 / 4.0));
}

TEST(ComputeApe, MatchesAHandWorkedAlignment) {
  // A square whose estimate is stretched by 10 % along x only: the best rigid alignment is the
  // identity about the centroid, each corner is off by 0.1.
  const Points truth = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const Points estimate = {{-1.1, -1, 0}, {1.1, -1, 0}, {1.1, 1, 0}, {-1.1, 1, 0}};
  const ApeStatistics ape = ComputeApe(truth, estimate);
  EXPECT_NEAR(ape.rmse, 0.1, 1e-12);
  EXPECT_NEAR(ape.mean, 0.1, 1e-12);
}

TEST(ComputeApe, NeedsThreePoses) {
  EXPECT_THROW(ComputeApe({{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {1, 0, 0}}), CheckError);
  EXPECT_THROW(ComputeApeUnaligned({}, {}), CheckError);
}

}  // namespace
}  // namespace deja_view
