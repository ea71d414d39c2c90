#include "deja_view/pipeline/loop_closer.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "small_flight.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::DefaultOutcome;
using test::FlightOptions;
using test::FlightVocabulary;
using test::SmallFlight;

/// The explanation of a pair, and how many loops the flight found beside.
std::pair<std::optional<PairExplanation>, std::size_t> ExplainIn(const LoopCloserOptions& options,
                                                                 std::int64_t current_ns,
                                                                 std::int64_t old_ns,
                                                                 std::int64_t within_ns = 500) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloser closer(options, flight.camera, flight.T_B_C, FlightVocabulary());
  closer.Ask(current_ns, old_ns, within_ns);
  std::optional<PairExplanation> explanation;
  for (const KeyframeInput& keyframe : flight.keyframes) {
    const KeyframeReport report = closer.AddKeyframe(keyframe);
    if (report.explanation) {
      EXPECT_FALSE(explanation) << "once";
      explanation = report.explanation;
    }
  }
  closer.OptimizeFully();
  return {explanation, closer.accepted_loops().size()};
}

const LoopReport& FirstLoop(bool is_accepted) {
  for (const KeyframeReport& report : DefaultOutcome().reports) {
    for (const LoopReport& loop : report.loops) {
      if (loop.current == report.index && loop.accepted() == is_accepted &&
          loop.reason != RejectReason::kInconsistent) {
        return loop;
      }
    }
  }
  throw std::logic_error("no such loop");
}

TEST(Explain, TellsOfAnAcceptedLoop) {
  const LoopReport& loop = FirstLoop(true);
  const auto [pair, loops] = ExplainIn(FlightOptions(), loop.stamp_current_ns, loop.stamp_old_ns);
  ASSERT_TRUE(pair);
  EXPECT_EQ(loops, DefaultOutcome().loops.size()) << "asking changes nothing";
  EXPECT_EQ(pair->current, loop.current);
  EXPECT_EQ(pair->old, loop.old);
  EXPECT_EQ(pair->reason, RejectReason::kNone);
  EXPECT_TRUE(pair->is_place);
  EXPECT_GE(pair->rank, 0);
  EXPECT_LT(pair->rank, pair->candidates);
  EXPECT_EQ(pair->score, loop.score);
  EXPECT_EQ(pair->real.verification.inliers, loop.inliers);
  EXPECT_EQ(static_cast<int>(pair->real.pairs.size()), loop.inliers);
  EXPECT_EQ(static_cast<int>(pair->first_matches.size()), loop.matches);
  ASSERT_TRUE(pair->T_Bold_Bcurrent_predicted);
  EXPECT_GT(pair->predicted_overlap, 0.3);
  for (const GateReading& reading : pair->real.readings) {
    EXPECT_TRUE(reading.passes()) << reading.option;
  }
}

TEST(Explain, NamesTheFirstGateThatFails) {
  const LoopReport& loop = FirstLoop(true);
  LoopCloserOptions options = FlightOptions();
  options.verification.max_sigma_m = 1e-6;
  options.verification.min_inlier_ratio = 0.99;
  const auto [pair, loops] = ExplainIn(options, loop.stamp_current_ns, loop.stamp_old_ns);
  ASSERT_TRUE(pair);
  EXPECT_EQ(loops, 0U);
  EXPECT_EQ(pair->reason, RejectReason::kLowInlierRatio);
  const auto& readings = pair->real.readings;
  const auto failed = std::find_if(
      readings.begin(), readings.end(), [](const GateReading& r) { return !r.passes(); });
  ASSERT_NE(failed, readings.end());
  EXPECT_EQ(failed->option, "min_inlier_ratio");
  EXPECT_EQ(failed->reason, pair->reason);
  EXPECT_FALSE(readings.back().passes());
}

TEST(Explain, TellsThatALoopWaitsForOthers) {
  const LoopReport& loop = FirstLoop(true);
  LoopCloserOptions options = FlightOptions();
  options.consistency.min_support = 1000;
  options.consistency.min_support_join = 1000;
  const auto [pair, loops] = ExplainIn(options, loop.stamp_current_ns, loop.stamp_old_ns);
  ASSERT_TRUE(pair);
  EXPECT_EQ(loops, 0U);
  EXPECT_EQ(pair->real.verification.reason, RejectReason::kNone);
  EXPECT_EQ(pair->reason, RejectReason::kInconsistent);
}

TEST(Explain, VerifiesAPairThatIsNoPlaceOrWasNotTried) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  const std::vector<KeyframeInfo>& keyframes = DefaultOutcome().keyframes;
  LoopCloserOptions options = FlightOptions();
  options.map_spacing_m = 100;  // the first keyframe stands for all
  options.map_spacing_deg = 180;
  const std::int64_t old_ns = keyframes[1].stamp_ns;
  const auto [pair, loops] = ExplainIn(options, keyframes[2].stamp_ns + 400, old_ns - 400);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->old, 1);
  EXPECT_FALSE(pair->is_place);
  EXPECT_EQ(pair->rank, -1);
  EXPECT_EQ(pair->reason, RejectReason::kNone) << "neighbours see the same";
  EXPECT_GT(flight.keyframes.size(), 3U);
}

TEST(Explain, TellsNothingOfWhatIsNotThere) {
  const std::vector<KeyframeInfo>& keyframes = DefaultOutcome().keyframes;
  const std::int64_t a = keyframes[5].stamp_ns;
  const std::int64_t b = keyframes[9].stamp_ns;
  EXPECT_FALSE(ExplainIn(FlightOptions(), b, a + 600).first) << "no keyframe of this stamp";
  EXPECT_FALSE(ExplainIn(FlightOptions(), a, b).first) << "the old one comes later";
  EXPECT_TRUE(ExplainIn(FlightOptions(), b, a + 600, 1000).first);
  const std::int64_t within_ns = keyframes[6].stamp_ns - a;
  const std::int64_t late_ns = keyframes[40].stamp_ns;
  const auto pair = ExplainIn(FlightOptions(), late_ns, keyframes[6].stamp_ns, within_ns).first;
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->old, 5) << "the first that is near enough";
}

}  // namespace
}  // namespace deja_view
