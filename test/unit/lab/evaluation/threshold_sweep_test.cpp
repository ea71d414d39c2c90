#include "deja_view/lab/evaluation/threshold_sweep.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

const std::vector<ScoredDecision> kDecisions = {
    {0.5, true}, {0.9, true}, {0.7, false}, {0.8, true}, {0.8, true}, {0.6, true, false}};

TEST(ThresholdSweep, CountsByHand) {
  const auto sweep = SweepThreshold(kDecisions, 8);
  ASSERT_EQ(sweep.size(), 5U);  // 0.8 occurs twice
  EXPECT_EQ(sweep[0].r, 0.9);
  EXPECT_EQ(sweep[0].precision, 1.0);
  EXPECT_EQ(sweep[0].recall, 1.0 / 8);
  EXPECT_EQ(sweep[1].found, 3);
  EXPECT_EQ(sweep[1].recall, 3.0 / 8);
  EXPECT_EQ(sweep[2].precision, 3.0 / 4);
  EXPECT_EQ(sweep[3].correct, 4);
  EXPECT_EQ(sweep[3].recall, 3.0 / 8) << "right, but nothing that had to be found";
  EXPECT_EQ(sweep[4].precision, 5.0 / 6);
  EXPECT_EQ(sweep[4].recall, 4.0 / 8);
}

TEST(ThresholdSweep, PicksTheLowestThresholdOfThatPrecision) {
  const auto sweep = SweepThreshold(kDecisions, 8);
  EXPECT_EQ(PickThreshold(sweep, 1.0).r, 0.8);
  EXPECT_EQ(PickThreshold(sweep, 1.0).recall, 3.0 / 8);
  EXPECT_EQ(PickThreshold(sweep, 0.8).r, 0.5);
}

TEST(ThresholdSweep, NothingToPick) {
  EXPECT_TRUE(SweepThreshold({}, 5).empty());
  EXPECT_TRUE(std::isinf(PickThreshold({}, 1.0).r));
  const auto wrong = SweepThreshold({{0.5, false}}, 5);
  EXPECT_EQ(PickThreshold(wrong, 1.0).recall, 0.0);
  EXPECT_TRUE(std::isinf(PickThreshold(wrong, 1.0).r));
  EXPECT_EQ(SweepThreshold({{0.5, true}}, 0).front().recall, 0.0);
}

}  // namespace
}  // namespace deja_view
