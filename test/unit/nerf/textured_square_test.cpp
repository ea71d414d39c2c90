#include "textured_square.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace deja_view::nerf::internal {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 16;

/// Grey, but for the checkered right quarter; rows have a gap behind them.
class TexturedSquareTest : public ::testing::Test {
 protected:
  TexturedSquareTest() : bytes_(kHeight * row_, 128) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < static_cast<int>(row_); ++x) {
        if (x >= kWidth * 3 / 4) {
          bytes_[static_cast<std::size_t>(y) * row_ + static_cast<std::size_t>(x)] =
              (x + y) % 2 == 0 ? 0 : 255;
        }
      }
    }
  }

  PixelRows Image() const { return {bytes_.data(), kWidth, kHeight, 1, row_}; }

  /// Of 1000 squares, how many touch the checkers.
  int CountTextured(const SquareOptions& options) const {
    int count = 0;
    Random random(1, 2);
    for (int i = 0; i < 1000; ++i) {
      const SquareCorner at = DrawSquare(Image(), options, &random);
      EXPECT_GE(at.x, 0);
      EXPECT_LE(at.x, kWidth - options.side);
      EXPECT_GE(at.y, 0);
      EXPECT_LE(at.y, kHeight - options.side);
      count += at.x + options.side > kWidth * 3 / 4 ? 1 : 0;
    }
    return count;
  }

  const std::size_t row_ = kWidth + 7;
  std::vector<std::uint8_t> bytes_;
};

TEST_F(TexturedSquareTest, ContrastIsBetweenBrightestAndDarkest) {
  EXPECT_EQ(Contrast(Image(), {0, 0}, 4), 0);
  EXPECT_EQ(Contrast(Image(), {kWidth * 3 / 4 - 4, 2}, 4), 0);
  EXPECT_EQ(Contrast(Image(), {kWidth * 3 / 4 - 3, 2}, 4), 255);
  EXPECT_EQ(Contrast(Image(), {kWidth - 4, kHeight - 4}, 4), 255);
}

TEST_F(TexturedSquareTest, PrefersWhatShowsSomething) {
  EXPECT_NEAR(CountTextured({4, 0.0F, 4}), 262, 50);  // 16 of 61 corners
  EXPECT_NEAR(CountTextured({4, 1.0F, 1}), 262, 50);
  EXPECT_NEAR(CountTextured({4, 1.0F, 4}), 1000 - 297, 50);  // 1 - (45 / 61)^4
  EXPECT_NEAR(CountTextured({4, 0.5F, 4}), 482, 55);
}

TEST_F(TexturedSquareTest, TakesTheSameNumbersWhateverItFinds) {
  const SquareOptions never{4, 0.0F, 3};
  const SquareOptions always{4, 1.0F, 3};
  Random skipped(5, 6);
  skipped.Skip(NumbersPerSquare(never));
  const auto next = skipped.Next();
  for (const SquareOptions& options : {never, always}) {
    Random random(5, 6);
    DrawSquare(Image(), options, &random);
    EXPECT_EQ(random.Next(), next);
  }
}

}  // namespace
}  // namespace deja_view::nerf::internal
