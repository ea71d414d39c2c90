#include "deja_view/pipeline/loop_closer.hpp"

#include <algorithm>

#include "small_flight.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::DefaultOutcome;
using test::FlightOptions;
using test::Fly;
using test::Outcome;

LoopCloserOptions ScoredOptions() {
  LoopCloserOptions options = FlightOptions();
  options.scoring.is_on = true;
  options.candidates.nearby = 0;
  return options;
}

std::vector<double> BestScores(const Outcome& outcome) {
  std::vector<double> scores;
  for (const KeyframeReport& report : outcome.reports) {
    scores.push_back(report.best_place ? report.best_place->score : 0.0);
  }
  return scores;
}

TEST(Scoring, FindsLoops) {
  const Outcome outcome = Fly(ScoredOptions());
  EXPECT_GT(outcome.loops.size(), 5U);
  for (const KeyframeReport& report : outcome.reports) {
    if (report.best_place) {
      EXPECT_GE(report.best_place->old, 0);
      EXPECT_LT(report.best_place->old, report.index);
    }
  }
}

TEST(Scoring, ThresholdKeepsCandidatesOut) {
  LoopCloserOptions options = ScoredOptions();
  options.scoring.threshold = LoopThreshold::kPair;
  const Outcome all = Fly(options);
  options.scoring.r = 1.6;  // above the range
  const Outcome none = Fly(options);
  EXPECT_TRUE(none.loops.empty());
  EXPECT_EQ(BestScores(all), BestScores(none)) << "scores are told whether or not they suffice";
  for (const KeyframeReport& report : none.reports) {
    EXPECT_TRUE(report.loops.empty());
    EXPECT_LE(report.best_place ? report.best_place->score : 0.0, 1.5);
  }
}

TEST(Scoring, ModesChangeTheScores) {
  std::vector<std::vector<double>> seen;
  for (const WordWeighting weights :
       {WordWeighting::kTfidf, WordWeighting::kPrinted, WordWeighting::kText}) {
    LoopCloserOptions options = ScoredOptions();
    options.scoring.weights = weights;
    seen.push_back(BestScores(Fly(options)));
    for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
      EXPECT_NE(seen[i], seen.back());
    }
  }
  LoopCloserOptions options = ScoredOptions();
  options.scoring.threshold = LoopThreshold::kSum;
  EXPECT_NE(BestScores(Fly(options)), seen.front());
}

TEST(Scoring, OffItChangesNothing) {
  LoopCloserOptions options = FlightOptions();
  options.scoring.is_on = false;
  const Outcome plain = Fly(options);
  EXPECT_NE(BestScores(plain), BestScores(DefaultOutcome()));
  options.scoring.r = 99;
  options.scoring.weights = WordWeighting::kPrinted;
  const Outcome outcome = Fly(options);
  EXPECT_EQ(BestScores(outcome), BestScores(plain));
  EXPECT_EQ(outcome.loops.size(), plain.loops.size());
}

}  // namespace
}  // namespace deja_view
