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

/// Points on a grid over 640 x 480 with odds of 1 %, and as many found of them as asked.
double Log10Of(int found, float spacing_px) {
  ChanceOfSupport chance(640, 480);
  int left = found;
  for (float y = 5; y < 480; y += 40) {
    for (float x = 5; x < 640; x += 40) {
      chance.AddVisible({x, y}, 0.01);
    }
  }
  for (float y = 5; left > 0; y += spacing_px) {
    for (float x = 5; x < 640 && left > 0; x += spacing_px, --left) {
      chance.AddFound({x, y});
    }
  }
  return chance.Log10Probability(2);
}

TEST(ChanceOfSupport, FewAreImprobableWhenTheySpread) {
  EXPECT_EQ(Log10Of(2, 40), 0) << "those that made the pose";
  EXPECT_GT(Log10Of(4, 40), -2);
  EXPECT_LT(Log10Of(15, 40), -6);
}

TEST(ChanceOfSupport, CrowdsCountOnce) {
  EXPECT_NEAR(Log10Of(60, 5), Log10Of(8, 40), 1e-9) << "60 in a row of 300 px: 8 cells";
  EXPECT_EQ(Log10Of(2, 5), 0);
}

TEST(ChanceOfSupport, IsCalibratedOnChance) {
  // Of trials in which chance alone finds, at most a share of x may be called less probable than x.
  Random random(3);
  int below_one_percent = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    ChanceOfSupport chance(640, 480);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2f pixel(static_cast<float>(random.Uniform(0, 640)),
                                  static_cast<float>(random.Uniform(0, 480)));
      const double p = random.Uniform(0.005, 0.05);
      chance.AddVisible(pixel, p);
      if (random.Uniform(0, 1) < p) {
        chance.AddFound(pixel);
      }
    }
    below_one_percent += chance.Log10Probability(0) <= -2 ? 1 : 0;
  }
  EXPECT_LE(below_one_percent, 0.015 * kTrials);
  EXPECT_GT(below_one_percent, 0.002 * kTrials);
}

}  // namespace
}  // namespace deja_view
