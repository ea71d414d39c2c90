#include "deja_view/lab/report/sweep.hpp"

#include "deja_view/base/check.hpp"

#include "temporary_directory.hpp"
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

constexpr const char* kPoints = "r,found,correct,precision,recall\n";
constexpr const char* kDetections = "stamp_current_ns,stamp_old_ns,score,correct,revisit\n";

class SweepFiles : public TemporaryDirectoryTest {
 protected:
  std::string ReadError() {
    try {
      ReadSweep(directory_);
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
};

TEST_F(SweepFiles, AreRead) {
  Write("sweep.csv", std::string(kPoints) + "0.9,1,1,1.0,0.25\n0.5,2,1,0.5,0.25\n");
  Sweep sweep = ReadSweep(directory_);
  ASSERT_EQ(sweep.points.size(), 2U);
  EXPECT_EQ(sweep.name, directory_.filename().string());
  EXPECT_EQ(sweep.points[1].r, 0.5);
  EXPECT_EQ(sweep.points[1].found, 2);
  EXPECT_EQ(sweep.points[1].correct, 1);
  EXPECT_EQ(sweep.points[1].precision, 0.5);
  EXPECT_EQ(sweep.points[1].recall, 0.25);
  EXPECT_TRUE(sweep.detections.empty());
  Write("detections.csv", std::string(kDetections) + "1600000000000000007,5,0.5,0,1\n");
  sweep = ReadSweep(directory_);
  ASSERT_EQ(sweep.detections.size(), 1U);
  EXPECT_EQ(sweep.detections[0].stamp_current_ns, 1600000000000000007);
  EXPECT_EQ(sweep.detections[0].stamp_old_ns, 5);
  EXPECT_FALSE(sweep.detections[0].decision.is_correct);
  EXPECT_TRUE(sweep.detections[0].decision.is_revisit);
}

TEST_F(SweepFiles, ThatAreBadAreNamed) {
  EXPECT_NE(ReadError().find("sweep.csv:1"), std::string::npos);
  Write("sweep.csv", std::string(kPoints) + "0.9,1\n");
  EXPECT_NE(ReadError().find("sweep.csv:2"), std::string::npos);
  Write("sweep.csv", kPoints);
  Write("detections.csv", std::string(kDetections) + "1,2,0.5,1,1\n1,2,x,1,1\n");
  EXPECT_NE(ReadError().find("detections.csv:3"), std::string::npos);
}

Sweep Example() {
  Sweep sweep{"sum", {{0.9, 1, 1, 1.0, 0.2}, {0.7, 3, 3, 1.0, 0.6}, {0.5, 5, 4, 0.8, 0.6}}, {}};
  sweep.detections = {{1000, 0, {0.9, true, true}},
                      {2000000000, 0, {0.7, false, false}},
                      {3000000000, 0, {0.5, false, true}}};
  return sweep;
}

TEST(Sweep, TellsTheChosenThreshold) {
  EXPECT_NE(ScoreFigure(Example()).find("Scores: sum; r = 0.700 for precision 1, recall 0.600"),
            std::string::npos);
  const auto rows = ThresholdRows({Example()});
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1], (std::vector<std::string>{"sum", "0.700", "1.0000", "0.600", "3"}));
  Sweep wrong = Example();
  wrong.points = {{0.5, 1, 0, 0.0, 0.0}};
  EXPECT_NE(ScoreFigure(wrong).find("no r has precision 1"), std::string::npos);
  EXPECT_EQ(ThresholdRows({wrong})[1][2], "1 is never reached");
}

TEST(Sweep, DrawsEveryDetectionInItsColour) {
  const std::string svg = ScoreFigure(Example());
  for (const char* css_class : {"smalldot correct", "smalldot wrong", "smalldot refused"}) {
    // The dots themselves, and the legend's sample.
    const std::size_t first = svg.find(css_class);
    ASSERT_NE(first, std::string::npos) << css_class;
    EXPECT_NE(svg.find(css_class, first + 1), std::string::npos) << css_class;
  }
  Sweep none = Example();
  none.detections.pop_back();
  EXPECT_LT(ScoreFigure(none).size(), svg.size());
}

TEST(Sweep, CurvesHaveTheirNames) {
  Sweep other = Example();
  other.name = "pair";
  const std::string curves = SweepFigure({Example(), other});
  EXPECT_NE(curves.find("pair"), std::string::npos);
  EXPECT_NE(ThresholdFigure({Example(), other}).find("run1 dashed"), std::string::npos);
}

}  // namespace
}  // namespace deja_view::report
