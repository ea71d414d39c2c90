#include "max_coverage.hpp"

#include "deja_view/base/random.hpp"

#include <algorithm>

#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(MaxCoverageTest, TakesWhatAddsMost) {
  MaxCoverage coverage(4);
  // 0 covers 0 and 1; 1 covers 1, 2 and a bit of 3; 3 covers 3.
  coverage.Add(0, 0, 1);
  coverage.Add(1, 0, 1);
  coverage.Add(1, 1, 1);
  coverage.Add(2, 1, 1);
  coverage.Add(3, 1, 0.25);
  coverage.Add(3, 3, 1);
  // 1 adds 2.25; then 0 adds 1 and 3 adds 0.75.
  EXPECT_THAT(coverage.Choose(10, 0.1), ElementsAre(1, 0, 3));
}

TEST(MaxCoverageTest, KeepsToTheBudgetAndLeavesTheRest) {
  const auto make = [] {
    MaxCoverage coverage(3);
    coverage.Add(0, 0, 1);
    coverage.Add(1, 1, 0.6);
    coverage.Add(2, 2, 0.4);
    return coverage;
  };
  EXPECT_THAT(make().Choose(2, 0.1), ElementsAre(0, 1));
  EXPECT_THAT(make().Choose(3, 0.5), ElementsAre(0, 1));
  EXPECT_THAT(make().Choose(0, 0.1), IsEmpty());
}

TEST(MaxCoverageTest, WhatIsCoveredNeedsNothing) {
  MaxCoverage coverage(2);
  coverage.Raise(0, 0.9);
  coverage.Raise(0, 0.2);  // takes nothing back
  coverage.Add(0, 0, 1);
  coverage.Add(1, 1, 0.3);
  EXPECT_THAT(coverage.Choose(2, 0.05), ElementsAre(1, 0));
}

TEST(MaxCoverageTest, OfEqualsTheFirst) {
  MaxCoverage coverage(3);
  for (const std::size_t v : {2, 0, 1}) {
    coverage.Add(1, v, 1);
  }
  EXPECT_THAT(coverage.Choose(3, 0.5), ElementsAre(0));
}

TEST(MaxCoverageTest, IsWhatTryingAllEachTimeGives) {
  constexpr std::size_t kCount = 40;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    MaxCoverage coverage(kCount);
    std::vector<std::vector<double>> degrees(kCount, std::vector<double>(kCount, 0.0));
    for (std::size_t q = 0; q < kCount; ++q) {
      for (int k = 0; k < 6; ++k) {
        const std::size_t v = random.Below(kCount);
        if (degrees[v][q] == 0) {
          degrees[v][q] = random.Uniform();
          coverage.Add(q, v, degrees[v][q]);
        }
      }
    }
    std::vector<double> covered(kCount, 0.0);
    std::vector<std::size_t> expected;
    for (int round = 0; round < 8; ++round) {
      const auto gain = [&](std::size_t v) {
        double sum = 0;
        for (std::size_t q = 0; q < kCount; ++q) {
          sum += std::max(0.0, degrees[v][q] - covered[q]);
        }
        return sum;
      };
      std::size_t best = 0;
      for (std::size_t v = 1; v < kCount; ++v) {
        best = gain(v) > gain(best) ? v : best;
      }
      expected.push_back(best);
      for (std::size_t q = 0; q < kCount; ++q) {
        covered[q] = std::max(covered[q], degrees[best][q]);
      }
    }
    EXPECT_EQ(coverage.Choose(8, 1e-6), expected) << "seed " << seed;
  }
}

}  // namespace
}  // namespace deja_view
