#include "deja_view/lab/report/run.hpp"

#include <cmath>

#include "example_run.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

TEST(JudgeTest, AlignsBothTrajectoriesWithTheTruth) {
  const JudgedRun judged = Judge(ExampleRun(), ExampleGroundTruth(), Rigid3());
  ASSERT_TRUE(judged.corrected_ape && judged.vio_ape);
  EXPECT_LT(judged.corrected_ape->max, 1e-9);
  EXPECT_GT(judged.vio_ape->mean, 0.05);
  ASSERT_EQ(judged.corrected.size(), 81U);
  EXPECT_TRUE(judged.corrected[7].isApprox(ExampleTruth(ExampleStamp(7)).t, 1e-9));
  EXPECT_NEAR(
      judged.vio_errors[7], (judged.vio[7] - ExampleTruth(ExampleStamp(7)).t).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(judged.times_s[2], 1.0);
  EXPECT_EQ(judged.truth_path.size(), 801U);
}

TEST(JudgeTest, JudgesLoops) {
  const JudgedRun judged = Judge(ExampleRun(), ExampleGroundTruth(), Rigid3());
  EXPECT_THAT(judged.verdicts,
              ElementsAre(Verdict::kCorrect,
                          Verdict::kCorrect,
                          Verdict::kCorrect,
                          Verdict::kWrong,
                          Verdict::kCorrect));
  EXPECT_EQ(judged.AcceptedLoops(), 4);
  ASSERT_TRUE(judged.score);
  EXPECT_EQ(judged.score->accepted, 4);
  EXPECT_EQ(judged.score->correct, 3);
  EXPECT_THAT(judged.ends[0], Pair(41, 1));
  EXPECT_TRUE(judged.HasRecall());
}

TEST(JudgeTest, FindsWhatTheTruthCallsRevisits) {
  const JudgedRun judged = Judge(ExampleRun(), ExampleGroundTruth(), Rigid3());
  // From 18 s on (2 m and 40 degrees before the end of the first round) every keyframe sees a place
  // again; looking along z, the body turns about its axis, so that only distance counts.
  ASSERT_FALSE(judged.revisits.empty());
  for (const auto& [current, old] : judged.revisits) {
    EXPECT_GE(current - old, 20);
    EXPECT_LE((ExampleTruth(ExampleStamp(current)).t - ExampleTruth(ExampleStamp(old)).t).norm(),
              2.0);
  }
  EXPECT_THAT(judged.revisits, ::testing::Contains(Pair(60, 20)));
}

TEST(JudgeTest, KnowsNothingWithoutTruth) {
  const JudgedRun judged = Judge(ExampleRun(), Trajectory(), std::nullopt);
  EXPECT_FALSE(judged.vio_ape);
  EXPECT_FALSE(judged.score);
  EXPECT_FALSE(judged.HasRecall());
  EXPECT_TRUE(judged.truth_path.empty());
  EXPECT_TRUE(std::isnan(judged.vio_errors[0]));
  EXPECT_EQ(judged.verdicts[0], Verdict::kUnknown);
  EXPECT_TRUE(judged.corrected[0].isApprox(ExampleRun().corrected.poses[0].t));
}

TEST(JudgeTest, JudgesOnlyWhatTheTruthCovers) {
  Trajectory truth = ExampleGroundTruth();
  truth.stamps_ns.resize(500);  // 25 s
  truth.poses.resize(500);
  const JudgedRun judged = Judge(ExampleRun(), truth, Rigid3());
  EXPECT_FALSE(std::isnan(judged.vio_errors[49]));
  EXPECT_TRUE(std::isnan(judged.vio_errors[50]));
  EXPECT_EQ(judged.verdicts[3], Verdict::kUnknown);
  EXPECT_EQ(judged.score->judged, 3);
}

TEST(JudgeTest, TellsNoRecallForLoopsToALoadedMap) {
  RunData run = ExampleRun();
  run.loops.push_back(ExampleLoop(80, 0));
  run.loops.back().stamp_old_ns = 5;
  const JudgedRun judged = Judge(run, ExampleGroundTruth(), Rigid3());
  EXPECT_FALSE(judged.HasRecall());
  EXPECT_THAT(judged.ends.back(), Pair(80, -1));
  EXPECT_EQ(judged.verdicts.back(), Verdict::kUnknown);
  EXPECT_EQ(judged.score->judged, 4);
}

TEST(JudgeTest, AcceptsAnEmptyRun) {
  const JudgedRun judged = Judge(RunData(), ExampleGroundTruth(), Rigid3());
  EXPECT_FALSE(judged.vio_ape);
  EXPECT_EQ(judged.AcceptedLoops(), 0);
}

}  // namespace
}  // namespace deja_view::report
