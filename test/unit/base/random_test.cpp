#include "deja_view/base/random.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(RandomTest, IsSplitMix64) {
  Random random(1234567);  // the numbers of the reference implementation (Vigna)
  EXPECT_EQ(random.Next(), 6457827717110365317U);
  EXPECT_EQ(random.Next(), 3203168211198807973U);
  EXPECT_EQ(random.Next(), 9817491932198370423U);
}

TEST(RandomTest, StreamsOfOneSeedDiffer) {
  EXPECT_EQ(Random(1, 2).Next(), Random(1, 2).Next());
  EXPECT_NE(Random(1, 2).Next(), Random(1, 3).Next());
  EXPECT_NE(Random(1, 2).Next(), Random(2, 2).Next());
}

TEST(RandomTest, StaysInItsRangesAndFillsThem) {
  Random random(7);
  double sum = 0;
  float float_sum = 0;
  int below[5] = {};
  int index[5] = {};
  constexpr int kDraws = 10000;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.Uniform(-2, 6);
    ASSERT_TRUE(u >= -2 && u < 6);
    sum += u;
    const float f = random.UniformFloat();
    ASSERT_TRUE(f >= 0 && f < 1);
    float_sum += f;
    ++below[random.Below(5)];
    ++index[random.Index(5)];
  }
  EXPECT_NEAR(sum / kDraws, 2, 0.1);
  EXPECT_NEAR(float_sum / kDraws, 0.5F, 0.015F);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(below[i], kDraws / 5, 200);
    EXPECT_NEAR(index[i], kDraws / 5, 200);
  }
}

}  // namespace
}  // namespace deja_view
