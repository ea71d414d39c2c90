#include "slot_set.hpp"

#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

std::set<std::uint32_t> Content(const SlotSet& set) {
  std::set<std::uint32_t> content;
  if (!set.is_bitmap()) {
    content.insert(set.list(), set.list() + set.size());
    return content;
  }
  for (std::uint32_t slot = 0; slot < 32 * set.bitmap_words(); ++slot) {
    if ((set.bitmap()[slot / 32] >> (slot % 32) & 1U) != 0) {
      content.insert(slot);
    }
  }
  return content;
}

class SlotSetTest : public ::testing::TestWithParam<int> {};

// One slot in GetParam(): a list when it is large, a bitmap when it is small.
TEST_P(SlotSetTest, HoldsWhatWasAddedAndNotRemoved) {
  std::mt19937_64 rng(GetParam());
  SlotSet set;
  std::set<std::uint32_t> expected;
  for (std::uint32_t slot = 0; slot < 5000; ++slot) {
    if (rng() % static_cast<std::uint64_t>(GetParam()) == 0) {
      set.Add(slot, slot + 1);
      expected.insert(slot);
    }
    if (rng() % 100 == 0 && !expected.empty()) {
      set.Remove(*expected.begin());
      expected.erase(expected.begin());
      set.Remove(slot + 1);  // which is not in the set
    }
  }
  EXPECT_EQ(set.size(), expected.size());
  EXPECT_EQ(Content(set), expected);
  EXPECT_EQ(set.is_bitmap(), GetParam() < 35);
}

INSTANTIATE_TEST_SUITE_P(Densities, SlotSetTest, ::testing::Values(1, 3, 10, 30, 60, 200));

TEST(SlotSet, TakesSlotsInAnyOrder) {
  SlotSet set;
  std::set<std::uint32_t> expected;
  for (std::uint32_t slot = 300; slot-- > 100;) {
    set.Add(slot, 300);
    expected.insert(slot);
  }
  set.Add(1000, 1001);
  expected.insert(1000);
  EXPECT_TRUE(set.is_bitmap());
  EXPECT_EQ(Content(set), expected);
}

TEST(RepeatList, HoldsSlotsAndCounts) {
  RepeatList list;
  list.Add(7, 2);
  list.Add(kMaxSlots - 1, 255);
  list.Add(9, 3);
  list.Remove(7);
  list.Remove(8);  // which is not in the list
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list.slot(0), 9U);
  EXPECT_EQ(list.count(0), 3U);
  EXPECT_EQ(list.slot(1), kMaxSlots - 1);
  EXPECT_EQ(list.count(1), 255U);
}

}  // namespace
}  // namespace deja_view::internal
