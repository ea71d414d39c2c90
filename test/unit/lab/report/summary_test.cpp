#include "deja_view/lab/report/summary.hpp"

#include "example_run.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

using ::testing::HasSubstr;

TEST(SummaryTest, LinesUpColumns) {
  const std::string table = SummaryTable({Judge(ExampleRun(), ExampleGroundTruth(), Rigid3())});
  EXPECT_THAT(table, HasSubstr("                    odometry alone  with loops closed\n"));
  EXPECT_THAT(table, HasSubstr("mean error [m]  "));
  EXPECT_THAT(table, HasSubstr(" 0.0000 (-100 %)\n"));
  EXPECT_THAT(table, HasSubstr("loops accepted                   -                  4\n"));
  EXPECT_THAT(table, HasSubstr("precision                        -              0.750\n"));
  EXPECT_THAT(table, HasSubstr("candidates refused: 1 too_few_inliers\n"));
}

TEST(SummaryTest, NamesRunsAndLeavesOutWhatIsUnknown) {
  JudgedRun other = Judge(ExampleRun(), Trajectory(), std::nullopt);
  other.run.name = "other";
  const std::string table = SummaryTable({Judge(ExampleRun(), Trajectory(), std::nullopt), other});
  EXPECT_THAT(table, HasSubstr("odometry alone  example  other\n"));
  EXPECT_THAT(table, HasSubstr("recall                           -        -      -\n"));
}

TEST(SummaryTest, JsonHasReplaysKeys) {
  const auto json = SummaryJson({Judge(ExampleRun(), ExampleGroundTruth(), Rigid3())});
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json[0]["name"], "example");
  EXPECT_EQ(json[0]["keyframes"], 81);
  EXPECT_EQ(json[0]["loops_accepted"], 4);
  EXPECT_EQ(json[0]["loops_correct"], 3);
  EXPECT_EQ(json[0]["precision"], 0.75);
  EXPECT_GT(json[0]["recall"].get<double>(), 0);
  EXPECT_LT(json[0]["ape_rmse_m"].get<double>(), 1e-9);
  EXPECT_GT(json[0]["vio_ape_mean_m"].get<double>(), 0.05);
}

TEST(SummaryTest, JsonIsNullWithoutTruth) {
  const auto json = SummaryJson({Judge(ExampleRun(), Trajectory(), std::nullopt)});
  for (const char* key : {"revisits", "loops_correct", "precision", "recall", "ape_mean_m"}) {
    ASSERT_TRUE(json[0].contains(key)) << key;
    EXPECT_TRUE(json[0][key].is_null()) << key;
  }
}

}  // namespace
}  // namespace deja_view::report
