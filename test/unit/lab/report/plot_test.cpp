#include "deja_view/lab/report/plot.hpp"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(RangeTest, PassesOverWhatIsNotFinite) {
  Range range;
  range.Include(
      {std::numeric_limits<double>::quiet_NaN(), 3, -1, std::numeric_limits<double>::infinity()});
  EXPECT_FALSE(range.is_empty);
  EXPECT_EQ(range.min, -1);
  EXPECT_EQ(range.max, 3);
}

TEST(TicksTest, StepsAreOfThe125Series) {
  EXPECT_DOUBLE_EQ(TickStep({0, 10, false}, 10), 1);
  EXPECT_DOUBLE_EQ(TickStep({0, 11, false}, 10), 2);
  EXPECT_DOUBLE_EQ(TickStep({0, 0.31, false}, 10), 0.05);
  EXPECT_DOUBLE_EQ(TickStep({0, 999, false}, 10), 100);
  EXPECT_DOUBLE_EQ(TickStep({}, 5), 1);
  EXPECT_DOUBLE_EQ(TickStep({2, 2, false}, 5), 1);
}

TEST(TicksTest, LieInTheRange) {
  EXPECT_THAT(Ticks({-0.1, 0.3, false}, 0.1),
              ElementsAre(DoubleNear(-0.1, 1e-12),
                          DoubleNear(0, 1e-12),
                          DoubleNear(0.1, 1e-12),
                          DoubleNear(0.2, 1e-12),
                          DoubleNear(0.3, 1e-12)));
}

TEST(TicksTest, LabelsHaveTheStepsDecimals) {
  EXPECT_EQ(TickLabel(0.1, 0.05), "0.10");
  EXPECT_EQ(TickLabel(20, 20), "20");
  EXPECT_EQ(TickLabel(-1e-17, 0.1), "0.0");
}

TEST(PlotTest, MapsValuesWithYUpwards) {
  const Plot plot({10, 20}, {100, 50}, {0, 10, false}, {-1, 1, false});
  EXPECT_TRUE(plot.ToPixel(0, -1).isApprox(Point(10, 70)));
  EXPECT_TRUE(plot.ToPixel(10, 1).isApprox(Point(110, 20)));
  EXPECT_TRUE(plot.ToPixels({5}, {0})[0].isApprox(Point(60, 45)));
}

TEST(PlotTest, CopesWithEmptyAndPointLikeRanges) {
  const Plot plot({0, 0}, {100, 100}, {}, {3, 3, false});
  EXPECT_TRUE(plot.ToPixel(0.5, 3).isApprox(Point(50, 50)));
  Svg svg(100, 100, "", "");
  plot.DrawAxes("x & y", "z", &svg);
  EXPECT_THAT(svg.ToString(), HasSubstr("x &amp; y"));
  EXPECT_THAT(svg.ToString(), Not(HasSubstr("nan")));
}

TEST(PlotTest, AnAxisWithoutANameHasNoTicks) {
  const Plot plot({0, 0}, {100, 100}, {0, 1, false}, {0, 1, false});
  Svg svg(100, 100, "", "");
  plot.DrawAxes("", "", &svg);
  EXPECT_THAT(svg.ToString(), Not(HasSubstr("<text")));
  EXPECT_THAT(svg.ToString(), HasSubstr("class=\"axis\""));
}

TEST(PlotTest, CountsCharactersNotBytes) {
  EXPECT_EQ(TextWidth("\xC3\xA4"), TextWidth("a"));
}

}  // namespace
}  // namespace deja_view::report
