#include "compact_bow.hpp"

#include <random>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

TEST(CompactBow, IsDecodedAsItWas) {
  std::mt19937_64 rng(1);
  BowVector bow = test::RandomBow(800, 5000, &rng);
  bow.entries.push_back({1000000, 7});
  bow.entries.push_back({0xffffffffU, 1});
  const CompactBow compact(bow);
  const BowVector decoded = compact.Decode();
  EXPECT_EQ(decoded.entries, bow.entries);
  EXPECT_EQ(decoded.descriptor_count, bow.descriptor_count);
  EXPECT_LT(compact.memory_bytes(), 2 * bow.entries.size());
}

TEST(CompactBow, CutsCounts) {
  BowVector bow;
  bow.entries = {{3, 1000}};
  EXPECT_EQ(CompactBow(bow).Decode().entries.at(0).count, 255U);
}

TEST(CompactBow, MayBeEmpty) {
  EXPECT_TRUE(CompactBow().Decode().entries.empty());
  EXPECT_TRUE(CompactBow(BowVector{}).Decode().entries.empty());
}

}  // namespace
}  // namespace deja_view::internal
