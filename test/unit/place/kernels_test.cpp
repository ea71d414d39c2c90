#include "kernels.hpp"

#include <cmath>
#include <random>

#include "instruction_sets.hpp"
#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

using test::OnEveryInstructionSet;

class AddBitmapsOf : public testing::TestWithParam<int> {};

// Bitmaps of different lengths; the sums are those of the longest.
TEST_P(AddBitmapsOf, AddsWeightsToSlots) {
  std::mt19937_64 rng(1);
  std::vector<std::vector<std::uint32_t>> bitmaps;
  for (int i = 0; i < GetParam(); ++i) {
    const std::uint32_t blocks[] = {1, 9, 5, 1};
    bitmaps.emplace_back(kBlockWords * blocks[i % 4]);
    for (std::uint32_t& word : bitmaps.back()) {
      word = static_cast<std::uint32_t>(rng() & rng());
    }
  }
  std::vector<WeightedBitmap<std::uint32_t>> jobs;
  std::vector<WeightedBitmap<std::uint64_t>> jobs_64;
  std::vector<std::uint32_t> start(9 * kBlockWords * 32);
  std::vector<std::uint64_t> start_64(9 * kBlockWords * 32);
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
  OnEveryInstructionSet([&] {
    std::vector<std::uint32_t> sums = start;
    AddBitmaps(jobs, sums.data());
    EXPECT_EQ(sums, expected);
    std::vector<std::uint64_t> sums_64 = start_64;
    AddBitmaps(jobs_64, sums_64.data());
    EXPECT_EQ(sums_64, expected_64);
  });
}

// Few are added one by one, many bit by bit.
INSTANTIATE_TEST_SUITE_P(Counts, AddBitmapsOf, testing::Values(1, 4, 31, 32, 100, 300));

TEST(PlaceKernels, PassWhatReachesTheThreshold) {
  constexpr std::uint32_t kSlots = 800;
  std::mt19937_64 rng(1);
  std::vector<std::uint32_t> norms(kSlots);
  std::vector<std::uint32_t> once(kSlots);
  std::vector<std::uint32_t> more(kSlots);
  std::vector<std::uint32_t> repeats(kSlots);
  std::vector<std::uint64_t> rest(kSlots);
  const std::uint64_t norm = 20000000;
  for (std::uint32_t slot = 0; slot < kSlots; ++slot) {
    norms[slot] = static_cast<std::uint32_t>(rng() % (3 * norm));
    if (slot % 5 != 0) {  // the others have nothing in common
      once[slot] = static_cast<std::uint32_t>(rng() % 6000000);
      more[slot] = static_cast<std::uint32_t>(rng() % 1000000);
      repeats[slot] = static_cast<std::uint32_t>(rng() % 500000);
      rest[slot] = rng() % (500000 * norm);
    }
  }
  const L1Parts parts = {norm, norms.data(), once.data(), more.data(), repeats.data(), rest.data()};
  for (const double threshold : {0.0, 0.1, 0.2, 0.9}) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t slot = 80; slot < 720; ++slot) {
      const double scale = static_cast<double>(norm) * static_cast<double>(norms[slot]);
      const std::uint64_t common = parts.Common(slot);
      if (common > 0 && static_cast<double>(common) >= threshold * scale) {
        expected.push_back(slot);
      }
    }
    OnEveryInstructionSet([&] {
      std::vector<std::uint32_t> found(kSlots);
      found.resize(FilterL1(parts, threshold, 80, 720, found.data()));
      EXPECT_EQ(found, expected) << threshold;
    });
  }
}

TEST(PlaceKernels, SumSynonymsWithTheSameBits) {
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> uniform(1, 3);
  std::vector<Descriptor> centroids = {test::RandomDescriptor(&rng)};
  std::vector<double> values = {2.0};
  while (centroids.size() < 150) {
    centroids.push_back(test::Disturb(centroids[rng() % centroids.size()], 25, &rng));
    values.push_back(uniform(rng));
  }
  std::vector<double> weights;
  for (int distance = 0; distance <= 40; ++distance) {
    weights.push_back(std::exp(-0.001 * distance * distance));
  }
  // By the definition.
  SynonymSums expected;
  int synonyms = 0;
  for (std::size_t i = 0; i < centroids.size(); ++i) {
    double sum = 0;
    double total = 0;
    for (std::size_t j = 0; j < centroids.size(); ++j) {
      const int d = HammingDistance(centroids[i], centroids[j]);
      const double k = i == j ? 1.0 : d <= 40 ? weights[static_cast<std::size_t>(d)] : 0.0;
      synonyms += i != j && k > 0 ? 1 : 0;
      sum += k * values[j];
      total += k;
    }
    expected.sums.push_back(sum);
    expected.totals.push_back(total);
  }
  EXPECT_GT(synonyms, 200);
  const SynonymSums first = SumSynonyms(centroids, values, weights);
  for (std::size_t i = 0; i < centroids.size(); ++i) {
    EXPECT_NEAR(first.sums[i], expected.sums[i], 1e-9);
    EXPECT_NEAR(first.totals[i], expected.totals[i], 1e-9);
  }
  OnEveryInstructionSet([&] {
    const SynonymSums s = SumSynonyms(centroids, values, weights);
    EXPECT_EQ(s.sums, first.sums);
    EXPECT_EQ(s.totals, first.totals);
  });
}

TEST(PlaceKernels, NoWordsHaveNoSynonyms) {
  EXPECT_TRUE(SumSynonyms({}, {}, {1.0}).sums.empty());
}

}  // namespace
}  // namespace deja_view::internal
