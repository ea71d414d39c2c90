#include "synonym_sums.hpp"

#include <cmath>
#include <random>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

TEST(SynonymSums, AllImplementationsGiveTheSameBits) {
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
  const auto functions = AvailableSumSynonyms();
  const SynonymSums first = functions.front()(centroids, values, weights);
  for (std::size_t i = 0; i < centroids.size(); ++i) {
    EXPECT_NEAR(first.sums[i], expected.sums[i], 1e-9);
    EXPECT_NEAR(first.totals[i], expected.totals[i], 1e-9);
  }
  for (const SumSynonymsFunction function : functions) {
    const SynonymSums s = function(centroids, values, weights);
    EXPECT_EQ(s.sums, first.sums);
    EXPECT_EQ(s.totals, first.totals);
  }
}

TEST(SynonymSums, NoWordsHaveNoSums) {
  EXPECT_TRUE(AvailableSumSynonyms().front()({}, {}, {1.0}).sums.empty());
}

}  // namespace
}  // namespace deja_view::internal
