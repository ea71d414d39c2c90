#include "deja_view/lab/report/svg.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(SvgTest, EscapesWhatXmlReserves) {
  EXPECT_EQ(EscapeXml("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&apos;");
  EXPECT_EQ(EscapeXml("na\xC3\xAFve\t"), "na\xC3\xAFve\t");
  EXPECT_EQ(EscapeXml(std::string("\0\x01z", 3)), "\xEF\xBF\xBD\xEF\xBF\xBDz");
}

TEST(SvgTest, FormatsNumbersShortly) {
  EXPECT_EQ(FormatNumber(1.5), "1.5");
  EXPECT_EQ(FormatNumber(-0.001), "0");
  EXPECT_EQ(FormatNumber(100), "100");
  EXPECT_EQ(FormatNumber(-3.256), "-3.26");
  EXPECT_THROW(FormatNumber(kNaN), CheckError);
  EXPECT_THROW(FormatNumber(std::numeric_limits<double>::infinity()), CheckError);
}

TEST(SvgTest, IsADocumentWithTitleAndEscapedText) {
  Svg svg(100, 50, "A & B", "<what>");
  svg.AddText("title", {1, 2}, "x < y", Anchor::kEnd);
  const std::string text = svg.ToString();
  EXPECT_THAT(text, HasSubstr("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 50\""));
  EXPECT_THAT(text, HasSubstr("<title>A &amp; B</title>"));
  EXPECT_THAT(text, HasSubstr("<desc>&lt;what&gt;</desc>"));
  EXPECT_THAT(
      text, HasSubstr("<text class=\"title\" x=\"1\" y=\"2\" text-anchor=\"end\">x &lt; y</text>"));
  EXPECT_EQ(text.substr(text.size() - 7), "</svg>\n");
}

TEST(SvgTest, SuitsLightAndDarkPages) {
  EXPECT_THAT(Svg(1, 1, "", "").ToString(), HasSubstr("@media (prefers-color-scheme:dark)"));
  EXPECT_THAT(StyleSheet(), HasSubstr(".e15{"));
  EXPECT_THAT(StyleSheet(), Not(HasSubstr(".e16{")));
}

TEST(SvgTest, LeavesGapsWherePointsAreNotFinite) {
  Svg svg(10, 10, "", "");
  svg.AddPolyline("line", {{0, 0}, {5, 0}, {kNaN, 0}, {5, 5}, {0, 5}});
  EXPECT_THAT(svg.ToString(), HasSubstr("<path class=\"line\" d=\"M0 0L5 0M5 5L0 5\"/>"));
}

TEST(SvgTest, LeavesOutPointsThatDoNotShow) {
  Svg svg(10, 10, "", "");
  svg.AddPolyline("line", {{0, 0}, {1, 0.05}, {2, 0}, {3, 1}, {2, 2.05}, {1, 3}});
  EXPECT_THAT(svg.ToString(), HasSubstr("d=\"M0 0L2 0L3 1L1 3\""));
}

TEST(SvgTest, KeepsTheTurnOfALineThatComesBack) {
  Svg svg(10, 10, "", "");
  svg.AddPolyline("line", {{0, 0}, {5, 0}, {0, 0}});
  svg.AddPolyline("dot", {{4, 4}});
  EXPECT_THAT(svg.ToString(), HasSubstr("d=\"M0 0L5 0L0 0\""));
  EXPECT_THAT(svg.ToString(), HasSubstr("class=\"dot\" d=\"M4 4\""));
}

TEST(SvgTest, DrawsAreasDownToTheirBase) {
  Svg svg(10, 10, "", "");
  svg.AddArea("area", {{1, 2}, {3, 4}}, 9);
  EXPECT_THAT(svg.ToString(), HasSubstr("d=\"M1 2L3 4V9H1Z\""));
}

TEST(SvgTest, PassesOverElementsThatAreNotFinite) {
  Svg svg(10, 10, "", "");
  const std::string before = svg.ToString();
  svg.AddRect("a", {kNaN, 0}, {1, 1});
  svg.AddLine("a", {0, 0}, {1, kNaN});
  svg.AddSegments("a", {{{kNaN, 0}, {1, 1}}});
  svg.AddBoxes("a", {{{0, 0}, {kNaN, 1}}});
  svg.AddDots("a", {{kNaN, 1}});
  svg.AddCircle("a", {kNaN, 1}, 2);
  svg.AddText("a", {kNaN, 1}, "a");
  svg.AddVerticalText("a", {1, kNaN}, "a");
  svg.AddPolyline("a", {{kNaN, 1}});
  svg.AddArea("a", {}, 1);
  EXPECT_EQ(svg.ToString(), before);
}

}  // namespace
}  // namespace deja_view::report
