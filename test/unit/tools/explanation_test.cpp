#include "explain/explanation.hpp"

#include "deja_view/base/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

PairExplanation ByChancePair() {
  PairExplanation pair;
  pair.current = 20;
  pair.old = 3;
  pair.stamp_current_ns = 12'500'000'000;
  pair.stamp_old_ns = 2'000'000'001;
  pair.is_place = true;
  pair.candidates = 6;
  pair.rank = 1;
  pair.points_current = 80;
  pair.real.verification.inliers = 9;
  pair.real.verification.reason = RejectReason::kByChance;
  pair.real.readings = {{RejectReason::kByChance, "max_log10_false_alarms", -1.5, -2},
                        {RejectReason::kLowInlierRatio, "min_inlier_ratio", 0.4, 0.2, true}};
  pair.reason = RejectReason::kByChance;
  return pair;
}

TEST(ParseStamp, TakesSecondsAndNanoseconds) {
  EXPECT_EQ(ParseStamp("--pair", "12.5"), 12'500'000'000);
  EXPECT_EQ(ParseStamp("--pair", "1403636620"), 1'403'636'620'000'000'000);
  EXPECT_EQ(ParseStamp("--pair", "1012133333333"), 1'012'133'333'333);
  EXPECT_EQ(ParseStamp("--pair", "1403636620.000000001"), 1'403'636'620'000'000'001);
  EXPECT_EQ(ParseStamp("--pair", "1403636620000000001"), 1'403'636'620'000'000'001);
  for (const char* text : {"",
                           ".",
                           "1.",
                           "x",
                           "-1",
                           "1e9",
                           "1.0000000001",

                           "9999999999999999999",
                           "1403636620000000001.5"}) {
    EXPECT_THROW(ParseStamp("--pair", text), InputError) << text;
  }
}

TEST(Explanation, NamesTheGateThatFailed) {
  const auto lines = ExplanationLines(ByChancePair(), RejectReason::kByChance);
  EXPECT_THAT(lines,
              Contains(HasSubstr("20 of 12.500000000 s and the old keyframe 3 of "
                                 "2.000000001 s: by_chance")));
  EXPECT_THAT(lines, Contains(HasSubstr("number 2 of 6")));
  EXPECT_THAT(lines,
              Contains(HasSubstr("FAILS  verification.max_log10_false_alarms: -1.5, at most -2")));
  EXPECT_THAT(lines,
              Contains(HasSubstr("passes verification.min_inlier_ratio: 0.4, at least 0.2")));
  EXPECT_THAT(lines, Contains(HasSubstr("not of one world")));
  EXPECT_THAT(lines, Not(Contains(HasSubstr("virtual views"))));
  EXPECT_FALSE(ToJson(ByChancePair(), RejectReason::kByChance)["real"]["gates"][0]["passes"]);
}

TEST(Explanation, TellsWhatWasNotTried) {
  PairExplanation pair = ByChancePair();
  pair.rank = -1;
  EXPECT_THAT(ExplanationLines(pair, pair.reason), Contains(HasSubstr("not among the 6")));
  pair.is_place = false;
  EXPECT_THAT(ExplanationLines(pair, pair.reason), Contains(HasSubstr("is no place")));
}

TEST(Explanation, TellsWhatWasDecidedLater) {
  const PairExplanation pair = ByChancePair();
  LoopReport other;
  other.current = 20;
  other.old = 4;
  other.reason = RejectReason::kWithdrawn;
  LoopReport same = other;
  same.old = 3;
  same.reason = RejectReason::kNone;
  EXPECT_EQ(FinalReason(pair, {}), RejectReason::kByChance);
  EXPECT_EQ(FinalReason(pair, {same, other}), RejectReason::kNone);
  EXPECT_THAT(ExplanationLines(pair, RejectReason::kNone),
              Contains(HasSubstr("at that moment: by_chance; later: accepted")));
}

}  // namespace
}  // namespace deja_view
