#include "accumulate.hpp"

#include <random>

#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

TEST(AccumulateKernels, AllAddTheSame) {
  std::mt19937_64 rng(1);
  // Bitmaps of different lengths; the sums are those of the longest.
  std::vector<std::vector<std::uint32_t>> bitmaps;
  for (const std::uint32_t words : {4U, 36U, 20U, 4U}) {
    bitmaps.emplace_back(words);
    for (std::uint32_t& word : bitmaps.back()) {
      word = static_cast<std::uint32_t>(rng() & rng());
    }
  }
  std::vector<WeightedBitmap<std::uint32_t>> jobs;
  std::vector<WeightedBitmap<std::uint64_t>> jobs_64;
  std::vector<std::uint32_t> start(36 * 32);
  std::vector<std::uint64_t> start_64(36 * 32);
  for (std::size_t i = 0; i < start.size(); ++i) {
    start[i] = static_cast<std::uint32_t>(rng());
    start_64[i] = rng();
  }
  std::vector<std::uint32_t> expected = start;
  std::vector<std::uint64_t> expected_64 = start_64;
  for (const std::vector<std::uint32_t>& bitmap : bitmaps) {
    const auto words = static_cast<std::uint32_t>(bitmap.size());
    jobs.push_back({bitmap.data(), words, static_cast<std::uint32_t>(rng())});
    jobs_64.push_back({bitmap.data(), words, rng()});
    for (std::size_t i = 0; i < bitmap.size() * 32; ++i) {
      const bool is_set = (bitmap[i / 32] >> (i % 32) & 1U) != 0;
      expected[i] += is_set ? jobs.back().weight : 0;
      expected_64[i] += is_set ? jobs_64.back().weight : 0;
    }
  }
  for (const AccumulateKernel& kernel : AvailableAccumulateKernels()) {
    std::vector<std::uint32_t> sums = start;
    kernel.Add(jobs, sums.data());
    EXPECT_EQ(sums, expected) << kernel.name;
    std::vector<std::uint64_t> sums_64 = start_64;
    kernel.Add(jobs_64, sums_64.data());
    EXPECT_EQ(sums_64, expected_64) << kernel.name;
  }
}

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
  sums.Finish(AvailableAccumulateKernels().front());
  for (std::uint32_t slot = 0; slot < kSlots; ++slot) {
    ASSERT_EQ(sums[slot], expected[slot]);
  }
}

}  // namespace
}  // namespace deja_view::internal
