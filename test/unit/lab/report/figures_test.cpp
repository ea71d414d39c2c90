#include "deja_view/lab/report/figures.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "example_run.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t Occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

/// Every element that is opened is closed, in order; no number is "nan" or "inf".
void ExpectWellFormed(const std::string& svg) {
  std::vector<std::string> open;
  for (std::size_t at = svg.find('<'); at != std::string::npos; at = svg.find('<', at + 1)) {
    const std::size_t end = svg.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = svg.substr(at + 1, end - at - 1);
    ASSERT_EQ(tag.find('<'), std::string::npos) << tag;
    if (tag[0] == '/') {
      ASSERT_FALSE(open.empty());
      EXPECT_EQ(open.back(), tag.substr(1));
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(tag.substr(0, tag.find(' ')));
    }
  }
  EXPECT_TRUE(open.empty());
  for (const char* bad : {"\"nan", " nan", "nan\"", "\"inf", " inf", "inf\"", "Lnan", "Mnan"}) {
    EXPECT_THAT(svg, Not(HasSubstr(bad)));
  }
}

JudgedRun Judged() {
  return Judge(ExampleRun(), ExampleGroundTruth(), Rigid3());
}

TEST(TrajectoryFigureTest, ShowsBothTrajectoriesAndTheLoops) {
  const std::string svg = TrajectoryFigure(Judged());
  ExpectWellFormed(svg);
  EXPECT_THAT(svg, HasSubstr("Odometry alone"));
  EXPECT_THAT(svg, HasSubstr("With loops closed"));
  EXPECT_THAT(svg, HasSubstr("mean error 0.000 m, largest 0.000 m"));
  EXPECT_EQ(Occurrences(svg, "<path class=\"truth\""), 3U);  // the legend's too
  EXPECT_EQ(Occurrences(svg, "<path class=\"run0 wrong\""), 2U);
  EXPECT_THAT(svg, HasSubstr(">3 loops<"));
  EXPECT_THAT(svg, HasSubstr(">1 wrong loop<"));
  EXPECT_GT(Occurrences(svg, "<path class=\"error e"), 3U);
}

TEST(TrajectoryFigureTest, DrawsPlainLinesWithoutTruth) {
  const std::string svg = TrajectoryFigure(Judge(ExampleRun(), Trajectory(), std::nullopt));
  ExpectWellFormed(svg);
  EXPECT_THAT(svg, HasSubstr("<path class=\"vio\""));
  EXPECT_THAT(svg, Not(HasSubstr("<path class=\"error")));
  EXPECT_THAT(svg, Not(HasSubstr("mean error")));
  EXPECT_THAT(svg, HasSubstr(">4 loops<"));
}

TEST(TrajectoryFigureTest, LeavesAGapInAPause) {
  RunData run = ExampleRun();
  const auto count =
      Occurrences(TrajectoryFigure(Judge(run, Trajectory(), std::nullopt)), "<path class=\"vio\"");
  for (Trajectory* trajectory : {&run.vio, &run.corrected}) {
    trajectory->stamps_ns.erase(trajectory->stamps_ns.begin() + 30,
                                trajectory->stamps_ns.begin() + 40);
    trajectory->poses.erase(trajectory->poses.begin() + 30, trajectory->poses.begin() + 40);
  }
  EXPECT_EQ(
      Occurrences(TrajectoryFigure(Judge(run, Trajectory(), std::nullopt)), "<path class=\"vio\""),
      count + 1);
}

TEST(ErrorFigureTest, ShowsErrorsMeansAndLoops) {
  const std::string svg = ErrorFigure({Judged()});
  ExpectWellFormed(svg);
  EXPECT_THAT(svg, HasSubstr("odometry alone, mean 0."));
  EXPECT_THAT(svg, HasSubstr("with loops closed, mean 0.000 m"));
  EXPECT_EQ(Occurrences(svg, "<path class=\"tick wrong\""), 1U);
  EXPECT_EQ(Occurrences(svg, "<path class=\"tick correct\""), 2U);  // the legend's too
}

TEST(ErrorFigureTest, ComparesRunsByName) {
  JudgedRun other = Judged();
  other.run.name = "a<b";
  const std::string svg = ErrorFigure({Judged(), other});
  ExpectWellFormed(svg);
  EXPECT_THAT(svg, HasSubstr(">example, mean"));
  EXPECT_THAT(svg, HasSubstr(">a&lt;b, mean"));
  EXPECT_THAT(svg, HasSubstr("<path class=\"run1\""));
}

TEST(LoopFigureTest, ShowsEveryCandidate) {
  const std::string svg = LoopFigure(Judged());
  ExpectWellFormed(svg);
  EXPECT_THAT(svg, HasSubstr(">4 loops, precision 0.750, recall"));
  EXPECT_THAT(svg, HasSubstr("<path class=\"revisit\""));
  EXPECT_EQ(Occurrences(svg, "<path class=\"dot wrong\""), 2U);
  EXPECT_EQ(Occurrences(svg, "<path class=\"smalldot refused\""), 2U);
}

TEST(LoopFigureTest, PassesOverLoopsToALoadedMap) {
  RunData run = ExampleRun();
  for (LoopRecord& loop : run.loops) {
    loop.stamp_old_ns = 7;
  }
  const std::string svg = LoopFigure(Judge(run, ExampleGroundTruth(), Rigid3()));
  ExpectWellFormed(svg);
  EXPECT_EQ(Occurrences(svg, "<path class=\"dot correct\""), 1U);  // the legend's
}

TEST(FiguresTest, CopeWithAnEmptyRun) {
  const JudgedRun empty = Judge(RunData(), Trajectory(), std::nullopt);
  ExpectWellFormed(TrajectoryFigure(empty));
  ExpectWellFormed(ErrorFigure({empty}));
  ExpectWellFormed(LoopFigure(empty));
}

TEST(FiguresTest, CopeWithARunOfOneKeyframe) {
  RunData run;
  run.vio.stamps_ns = run.corrected.stamps_ns = {ExampleStamp(0)};
  run.vio.poses = run.corrected.poses = {Rigid3()};
  const JudgedRun judged = Judge(run, ExampleGroundTruth(), Rigid3());
  ExpectWellFormed(TrajectoryFigure(judged));
  ExpectWellFormed(ErrorFigure({judged}));
  ExpectWellFormed(LoopFigure(judged));
}

TEST(CountTest, KnowsSingularAndPlural) {
  EXPECT_EQ(Count(0, "loop"), "0 loops");
  EXPECT_EQ(Count(1, "loop"), "1 loop");
}

}  // namespace
}  // namespace deja_view::report
