#include "slot_sums.hpp"

#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

TEST(SlotSums, AddListsAndBitmaps) {
  constexpr std::uint32_t kSlots = 10000;
  SlotSet list;
  SlotSet bitmap;
  std::vector<std::uint32_t> expected(kSlots, 0);
  for (std::uint32_t slot = 0; slot < kSlots; slot += 7) {
    bitmap.Add(slot, slot + 1);
    expected[slot] += 3;
  }
  for (std::uint32_t slot = 5; slot < kSlots; slot += 1000) {
    list.Add(slot, slot + 1);
    expected[slot] += 11;
  }
  ASSERT_TRUE(bitmap.is_bitmap());
  ASSERT_FALSE(list.is_bitmap());
  SlotSums<std::uint32_t> sums(kSlots);
  sums.Add(bitmap, 3);
  sums.Add(list, 11);
  sums.Finish();
  for (std::uint32_t slot = 0; slot < kSlots; ++slot) {
    ASSERT_EQ(sums[slot], expected[slot]);
  }
}

}  // namespace
}  // namespace deja_view::internal
