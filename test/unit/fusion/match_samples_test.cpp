#include "deja_view/fusion/match_samples.hpp"

#include "deja_view/base/check.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

LoopMatches Loop(std::int64_t stamp_ns, bool is_virtual) {
  LoopMatches loop;
  loop.stamp_current_ns = stamp_ns;
  loop.is_virtual = is_virtual;
  return loop;
}

TEST(MatchSamples, KeepsAllOfAFew) {
  MatchSamples samples(4);
  samples.Add(Loop(3, true));
  samples.Add(Loop(1, false));
  samples.Add(Loop(2, false));
  const auto sorted = samples.Sorted();
  ASSERT_EQ(sorted.size(), 3U);
  EXPECT_EQ(sorted[0].stamp_current_ns, 1);
  EXPECT_TRUE(sorted[2].is_virtual);
}

TEST(MatchSamples, SpreadsOverAllOfMany) {
  for (const std::int64_t count : {9, 100, 1000, 1729}) {
    MatchSamples samples(8);
    for (std::int64_t i = 0; i < count; ++i) {
      samples.Add(Loop(i, false));
    }
    samples.Add(Loop(count, true));
    const auto sorted = samples.Sorted();
    ASSERT_GE(sorted.size(), 4U + 1U);
    ASSERT_LE(sorted.size(), 8U + 1U);
    EXPECT_TRUE(sorted.back().is_virtual) << "many real ones do not displace it";
    const std::int64_t stride = sorted[1].stamp_current_ns - sorted[0].stamp_current_ns;
    EXPECT_EQ(sorted[0].stamp_current_ns, 0);
    for (std::size_t i = 1; i + 1 < sorted.size(); ++i) {
      EXPECT_EQ(sorted[i].stamp_current_ns - sorted[i - 1].stamp_current_ns, stride);
    }
    EXPECT_GE(sorted[sorted.size() - 2].stamp_current_ns + stride, count) << "up to the end";
  }
}

TEST(MatchSamples, NeedsRoomForTwo) {
  EXPECT_THROW(MatchSamples(1), CheckError);
}

}  // namespace
}  // namespace deja_view
