#include "chance_of_support.hpp"

#include "deja_view/base/random.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(Log10UpperTail, IsTheBinomialsWhereOddsAreEqual) {
  // P(X >= 2) of 3 at 0.1: 3 * 0.01 * 0.9 + 0.001
  EXPECT_NEAR(Log10UpperTail({0.1, 0.1, 0.1}, 2), std::log10(0.028), 1e-12);
  EXPECT_NEAR(Log10UpperTail({0.1, 0.1, 0.1}, 3), -3, 1e-12);
  EXPECT_EQ(Log10UpperTail({0.1, 0.1, 0.1}, 0), 0);
}

TEST(Log10UpperTail, TakesUnequalOdds) {
  EXPECT_NEAR(Log10UpperTail({0.5, 0.1}, 1), std::log10(1 - 0.5 * 0.9), 1e-12);
  EXPECT_NEAR(Log10UpperTail({0.5, 0.1}, 2), std::log10(0.05), 1e-12);
  EXPECT_EQ(Log10UpperTail({0.5, 0.1}, 3), -300) << "impossible";
}

TEST(ChanceOfMatch, GrowsWithTheShareOfAlikeKeypointsAndWithTheirDensity) {
  const Descriptor zeros;
  Descriptor ones;
  ones.words.fill(~0ULL);
  std::vector<Descriptor> keypoints(100, ones);
  EXPECT_NEAR(ChanceOfMatch(zeros, keypoints, 80, 1), 0.5 / 101, 1e-12);
  for (std::size_t i = 0; i < 20; ++i) {
    keypoints[5 * i] = zeros;
  }
  EXPECT_NEAR(ChanceOfMatch(zeros, keypoints, 80, 1), 20.5 / 101, 1e-12);
  EXPECT_NEAR(ChanceOfMatch(zeros, keypoints, 80, 0.3), 1 - std::pow(1 - 20.5 / 101, 0.3), 1e-12);
}

/// Of 192 points with odds of 1 %, as many found as asked.
double Log10Of(int found) {
  constexpr std::size_t kPoints = 192;
  ChanceOfSupport chance(kPoints);
  for (std::size_t i = 0; i < kPoints; ++i) {
    chance.AddVisible(i, 0.01);
    if (i < static_cast<std::size_t>(found)) {
      chance.AddFound(i);
    }
  }
  return chance.Log10Probability(2);
}

TEST(ChanceOfSupport, FewAreImprobableWhenEachIs) {
  EXPECT_EQ(Log10Of(2), 0) << "those that made the pose";
  EXPECT_GT(Log10Of(4), -2);
  EXPECT_LT(Log10Of(15), -6);
}

TEST(ChanceOfSupport, PointsOfAGroupCountOnce) {
  ChanceOfSupport chance(8);
  for (std::size_t group = 0; group < 8; ++group) {
    for (int i = 0; i < 20; ++i) {
      chance.AddVisible(group, 0.01);
      chance.AddFound(group);
    }
  }
  const double p = 1 - std::pow(0.99, 20);
  const std::vector<double> as_one(8, p);
  EXPECT_NEAR(chance.Log10Probability(2), Log10UpperTail(as_one, 6), 1e-9);
}

TEST(ChanceOfSupport, ManyPointsWithFairOddsDoNotSaturate) {
  // 600 points that chance finds one in ten of: 90 say nothing, 150 a lot.
  ChanceOfSupport few(600);
  ChanceOfSupport many(600);
  for (std::size_t i = 0; i < 600; ++i) {
    few.AddVisible(i, 0.1);
    many.AddVisible(i, 0.1);
    if (i < 150) {
      many.AddFound(i);
    }
    if (i < 70) {
      few.AddFound(i);
    }
  }
  EXPECT_GT(few.Log10Probability(2), -2);
  EXPECT_LT(many.Log10Probability(2), -15);
}

TEST(ChanceOfSupport, IsCalibratedOnChance) {
  // Of trials in which chance alone finds, at most a share of x may be called less probable than x.
  Random random(3);
  int below_one_percent = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    ChanceOfSupport chance(200);
    for (std::size_t i = 0; i < 200; ++i) {
      const double p = random.Uniform(0.005, 0.05);
      chance.AddVisible(i, p);
      if (random.Uniform(0, 1) < p) {
        chance.AddFound(i);
      }
    }
    below_one_percent += chance.Log10Probability(0) <= -2 ? 1 : 0;
  }
  EXPECT_LE(below_one_percent, 0.015 * kTrials);
  EXPECT_GT(below_one_percent, 0.002 * kTrials);
}

TEST(CellOf, CutsTheImageIntoSixteenByTwelve) {
  EXPECT_EQ(CellOf({0, 0}, 640, 480), 0U);
  EXPECT_EQ(CellOf({41, 0}, 640, 480), 1U);
  EXPECT_EQ(CellOf({0, 41}, 640, 480), 16U);
  EXPECT_EQ(CellOf({640, 480}, 640, 480), kImageCells - 1) << "the edge belongs to the last";
}

}  // namespace
}  // namespace deja_view
