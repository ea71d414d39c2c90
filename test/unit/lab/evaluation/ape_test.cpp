#include "deja_view/lab/evaluation/ape.hpp"

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

// The positions and numbers that test/unit/evaluation/ape_reference.py prints: numpy's singular
// value decomposition and statistics, none of our code.
const Points kTruth = {{0, 0, 0}, {1, 0.2, 0}, {2, 0.1, 0.5}, {3, 1, 1}, {2.5, 2, 1.5}};
const Points kEstimate = {
    {5, 1, 0.1}, {5.1, 2.1, 0}, {4.9, 3, 0.6}, {4.1, 4.2, 0.9}, {3, 3.5, 1.7}};

void ExpectStatistics(
    const ApeStatistics& ape, double max, double mean, double median, double min, double rmse) {
  EXPECT_NEAR(ape.max, max, 1e-9);
  EXPECT_NEAR(ape.mean, mean, 1e-9);
  EXPECT_NEAR(ape.median, median, 1e-9);
  EXPECT_NEAR(ape.min, min, 1e-9);
  EXPECT_NEAR(ape.rmse, rmse, 1e-9);
}

TEST(ComputeApe, AgreesWithTheReference) {
  ExpectStatistics(ComputeApe(kTruth, kEstimate),
                   0.236083026436,
                   0.165515143056,
                   0.168324642887,
                   0.116501606806,
                   0.171626178009);
  ExpectStatistics(ComputeApe(kTruth, kEstimate, ApeAlignment::kYaw),
                   0.226720086460,
                   0.167246890172,
                   0.166841904389,
                   0.108344177340,
                   0.174140637844);
  ExpectStatistics(ComputeApe(kTruth, kEstimate, ApeAlignment::kNone),
                   5.1,
                   3.740057526289,
                   4.102438299353,
                   1.593737745051,
                   3.930903204100);
}

TEST(ComputeApe, YawLeavesATiltBe) {
  Points tilted;
  Points turned;
  for (const auto& p : kTruth) {
    tilted.push_back(Rigid3{ExpSo3({0.1, 0, 0}), {1, 2, 3}} * p);
    turned.push_back(Rigid3{FromYaw(2.5), {1, 2, 3}} * p);
  }
  EXPECT_LT(ComputeApe(kTruth, tilted).max, 1e-12);
  EXPECT_GT(ComputeApe(kTruth, tilted, ApeAlignment::kYaw).rmse, 0.02);
  EXPECT_LT(ComputeApe(kTruth, turned, ApeAlignment::kYaw).max, 1e-12);
}

TEST(PairByStamp, TakesTheNearestOfTheLongerList) {
  using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
  EXPECT_EQ(PairByStamp({10, 20, 30, 40}, {19, 33, 90}, 3), (Pairs{{1, 0}, {2, 1}}));
  EXPECT_EQ(PairByStamp({19, 33, 90}, {10, 20, 30, 40}, 3), (Pairs{{0, 1}, {1, 2}}));
  // As near: the earlier. Equally long lists: those of the second are looked for in the first.
  EXPECT_EQ(PairByStamp({10, 20, 30}, {15}, 5), (Pairs{{0, 0}}));
  EXPECT_EQ(PairByStamp({10, 12}, {11, 12}, 1), (Pairs{{0, 0}, {1, 1}}));
  EXPECT_TRUE(PairByStamp({}, {1}, 5).empty());
  EXPECT_TRUE(PairByStamp({1}, {}, 5).empty());
}

TEST(ComputeApe, NeedsThreePoses) {
  EXPECT_THROW(ComputeApe({{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {1, 0, 0}}), CheckError);
  EXPECT_THROW(ComputeApeUnaligned({}, {}), CheckError);
}

}  // namespace
}  // namespace deja_view
