#include "accumulate.hpp"

#include <random>

#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

TEST(AccumulateKernels, AllAddTheSame) {
  std::mt19937_64 rng(1);
  const std::uint32_t words = 37;
  std::vector<std::uint32_t> bitmap(words);
  for (std::uint32_t& word : bitmap) {
    word = static_cast<std::uint32_t>(rng() & rng());
  }
  std::vector<std::uint32_t> start(words * 32);
  std::vector<std::uint64_t> start_64(words * 32);
  for (std::size_t i = 0; i < start.size(); ++i) {
    start[i] = static_cast<std::uint32_t>(rng());
    start_64[i] = rng();
  }
  const std::uint32_t weight = 0U - 1234U;
  const std::uint64_t weight_64 = (std::uint64_t{1} << 40U) + 5;
  for (const AccumulateKernel& kernel : AvailableAccumulateKernels()) {
    std::vector<std::uint32_t> sums = start;
    std::vector<std::uint64_t> sums_64 = start_64;
    kernel.add_bitmap(bitmap.data(), words, weight, sums.data());
    kernel.add_bitmap_64(bitmap.data(), words, weight_64, sums_64.data());
    for (std::size_t i = 0; i < start.size(); ++i) {
      const bool is_set = (bitmap[i / 32] >> (i % 32) & 1U) != 0;
      ASSERT_EQ(sums[i], start[i] + (is_set ? weight : 0)) << kernel.name << " " << i;
      ASSERT_EQ(sums_64[i], start_64[i] + (is_set ? weight_64 : 0)) << kernel.name << " " << i;
    }
  }
}

TEST(Accumulator, AddsListsAndBitmaps) {
  constexpr std::uint32_t kSlots = 10000;  // several parts
  SlotSet list;
  SlotSet bitmap;
  std::vector<std::uint32_t> expected(Accumulator<std::uint32_t>::PaddedSlots(kSlots), 0);
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
  std::vector<std::uint32_t> sums(expected.size(), 0);
  Accumulator<std::uint32_t> accumulator(AvailableAccumulateKernels().front(), kSlots);
  accumulator.Add(bitmap, 3, sums.data());
  accumulator.Add(list, 11, sums.data());
  accumulator.Finish();
  EXPECT_EQ(sums, expected);
}

}  // namespace
}  // namespace deja_view::internal
