#include "deja_view/place/word_scoring.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>
#include <random>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr double kTight = 1e-12;

/// Three words with S = 1, 2, 5, so that p = 1/8, 1/4, 5/8 and S_bar = 8/7, 4/3, 8/3.
const WeightedBow kImage = {{2, 1.0}, {4, 2.0}, {7, 5.0}};

TEST(WordScoring, TfIdfIsTermFrequencyTimesIdf) {
  // Eq. 9: word 3 is 2 of 8 descriptors and in 10 of 1000 images, word 5 is 5 of 8 and in all.
  const BowVector bow{{{3, 2}, {5, 5}}, 8};
  const WeightedBow weighted =
      TfIdf(bow, [](WordId word) { return word == 3 ? std::log(1000.0 / 10.0) : std::log(1.0); });
  ASSERT_EQ(weighted.size(), 2U);
  EXPECT_EQ(weighted[0].word, 3U);
  EXPECT_NEAR(weighted[0].weight, 0.25 * 4.605170185988092, kTight);
  EXPECT_EQ(weighted[1].weight, 0.0);
}

/// What is left of the image's weights, each a share from `low` to `high`.
void ExpectWeights(const WeightedBow& weighted,
                   const std::vector<double>& expected,
                   double low,
                   double high) {
  ASSERT_EQ(weighted.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(weighted[i].weight, expected[i], kTight);
    EXPECT_GT(weighted[i].weight / kImage[i].weight, low);
    EXPECT_LT(weighted[i].weight / kImage[i].weight, high);
  }
}

TEST(WordScoring, TfIdfIsKeptWithoutMore) {
  const WeightedBow weighted = WeighWords(kImage, WordWeighting::kTfidf);
  EXPECT_EQ(weighted[2].weight, 5.0);
}

TEST(WordScoring, PrintedWeightsFallWithImportance) {
  // Eq. 8 as printed: S / (1 + S_bar): 1/(1 + 8/7), 2/(1 + 4/3), 5/(1 + 8/3).
  const WeightedBow weighted = WeighWords(kImage, WordWeighting::kPrinted);
  ExpectWeights(weighted, {7.0 / 15.0, 6.0 / 7.0, 15.0 / 11.0}, 0.0, 0.5);
  EXPECT_LT(weighted[2].weight / 5.0, weighted[0].weight / 1.0);
}

TEST(WordScoring, TextWeightsGrowWithImportance) {
  // S / (2 - p): 1/(15/8), 2/(7/4), 5/(11/8).
  ExpectWeights(
      WeighWords(kImage, WordWeighting::kText), {8.0 / 15.0, 8.0 / 7.0, 40.0 / 11.0}, 0.5, 1.0);
}

/// A vocabulary of four words: 1 is 10 bits from 0, 2 is 30 bits from 0 and 40 from 1, 3 far away.
std::shared_ptr<const Vocabulary> FourWords() {
  std::vector<Descriptor> words(4);
  words[1].words[0] = 0x3ffULL;
  words[2].words[1] = 0x3fffffffULL;
  words[3].words[2] = words[3].words[3] = ~0ULL;
  VocabularyTree tree;
  tree.k = 4;
  tree.levels = 1;
  for (std::int32_t i = 0; i < 4; ++i) {
    VocabularyNode node;
    node.id = i + 1;
    node.word = i;
    node.weight = 1.0;
    node.descriptor = words[static_cast<std::size_t>(i)];
    tree.nodes.push_back(node);
  }
  return Vocabulary::FromTree(tree);
}

TEST(WordScoring, SynonymsAreCloseCentroids) {
  const SynonymKernel kernel(FourWords(), 32, 10.0);
  EXPECT_EQ(kernel(0, 0), 1.0);
  EXPECT_NEAR(kernel(0, 1), std::exp(-0.5), kTight);
  EXPECT_NEAR(kernel(2, 0), std::exp(-4.5), kTight);
  EXPECT_EQ(kernel(1, 2), 0.0);  // 40 bits
  EXPECT_EQ(kernel(0, 3), 0.0);
  EXPECT_THROW(kernel.Average({{0, 1.0}}, {}), CheckError);
}

TEST(WordScoring, SynonymsOfOneImageAsOfAllPairs) {
  const auto vocabulary = Vocabulary::FromTree(test::RandomTree(8, 3, 5));
  const SynonymKernel kernel(vocabulary, 118, 60.0);
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> uniform(1, 3);
  WeightedBow image;
  std::vector<double> values;
  for (WordId word = 1; word < vocabulary->word_count(); word += 1 + word % 3) {
    image.push_back({word, 1.0});
    values.push_back(uniform(rng));
  }
  const std::vector<double> averages = kernel.Average(image, values);
  int synonyms = 0;
  for (std::size_t j = 0; j < image.size(); ++j) {
    double sum = 0;
    double total = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
      const int d =
          HammingDistance(vocabulary->Centroid(image[i].word), vocabulary->Centroid(image[j].word));
      const double k = i == j ? 1.0 : d <= 118 ? std::exp(-0.5 * d * d / 3600.0) : 0.0;
      synonyms += i != j && k > 0 ? 1 : 0;
      sum += k * values[i];
      total += k;
    }
    ASSERT_NEAR(averages[j], sum / total, 1e-9);
  }
  EXPECT_GT(synonyms, 100);
}

TEST(WordScoring, WordsGainFromImportantSynonyms) {
  const SynonymKernel kernel(FourWords(), 32, 10.0);
  // p = 0.1, 0.6, 0.3: S_bar = 10/9, 5/2, 10/7. Word 0 has the important synonym 1; 3 has none.
  const WeightedBow image = {{0, 1.0}, {1, 6.0}, {3, 3.0}};
  const WeightedBow weighted = WeighWords(image, WordWeighting::kSynonym, &kernel);
  const double k = std::exp(-0.5);
  EXPECT_NEAR(weighted[0].weight, 1.0 * (10.0 / 9.0 + k * 2.5) / (1.0 + k), kTight);
  EXPECT_NEAR(weighted[1].weight, 6.0 * (2.5 + k * 10.0 / 9.0) / (1.0 + k), kTight);
  EXPECT_NEAR(weighted[2].weight, 3.0 * 10.0 / 7.0, kTight);
  EXPECT_GT(weighted[0].weight, 10.0 / 9.0) << "gains from a synonym that matters more";
  EXPECT_THROW(WeighWords(image, WordWeighting::kSynonym), CheckError);
}

TEST(WordScoring, AnImageOfOneWordHasFiniteWeights) {
  const SynonymKernel kernel(FourWords(), 32, 10.0);
  for (const std::string_view name : kEnumNames<WordWeighting>) {
    const auto weighting = EnumFromString<WordWeighting>(name).value();
    const WeightedBow weighted = WeighWords({{1, 4.0}}, weighting, &kernel);
    EXPECT_TRUE(std::isfinite(weighted[0].weight)) << name;
  }
  EXPECT_EQ(WeighWords({{1, 0.0}}, WordWeighting::kText)[0].weight, 0.0);
}

TEST(WordScoring, SimilaritiesByHand) {
  const WeightedBow a = {{0, 3.0}, {1, 1.0}};
  const WeightedBow b = {{0, 1.0}, {1, 1.0}};
  EXPECT_NEAR(CosineSimilarity(a, b), 4.0 / std::sqrt(20.0), kTight);
}

TEST(WordScoring, SimilaritiesHaveTheirRange) {
  const WeightedBow a = {{0, 3.0}, {1, 1.0}};
  const WeightedBow other = {{5, 2.0}};
  const WeightedBow twice = {{0, 6.0}, {1, 2.0}};
  EXPECT_NEAR(CosineSimilarity(a, twice), 1.0, kTight);
  EXPECT_EQ(CosineSimilarity(a, other), 0.0);
  EXPECT_EQ(CosineSimilarity(a, {}), 0.0);
}

TEST(WordScoring, DynamicWeightsByHand) {
  // Eq. 15, alpha = 1: w_o = 0.5 + 0.2, score = 0.7 x 0.6 + 0.5 x 0.4.
  const CombinedScore original = CombineScores(0.6, 0.4);
  EXPECT_NEAR(original.weight_original, 0.7, kTight);
  EXPECT_NEAR(original.weight_virtual, 0.5, kTight);
  EXPECT_NEAR(original.score, 0.62, kTight);
  // beta = 0.5: w_v = 0.5 + 0.1, score = 0.5 x 0.4 + 0.6 x 0.6.
  const CombinedScore view = CombineScores(0.4, 0.6);
  EXPECT_NEAR(view.weight_original, 0.5, kTight);
  EXPECT_NEAR(view.weight_virtual, 0.6, kTight);
  EXPECT_NEAR(view.score, 0.56, kTight);
  EXPECT_NEAR(CombineScores(0.4, 0.6, {1.0, 2.0}).score, 0.2 + 0.9 * 0.6, kTight);
}

TEST(WordScoring, CombinedScoresStayInTheirRange) {
  EXPECT_NEAR(CombineScores(1, 1).score, 1.0, kTight);
  EXPECT_NEAR(CombineScores(1, 0).score, 1.5, kTight);
  EXPECT_NEAR(CombineScores(0, 1).score, 1.0, kTight);
  EXPECT_EQ(CombineScores(0, 0).score, 0.0);
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 1000; ++i) {
    const double score = CombineScores(uniform(rng), uniform(rng)).score;
    EXPECT_GE(score, 0);
    EXPECT_LE(score, 1.5);
  }
}

TEST(WordScoring, ThresholdModes) {
  const std::vector<double> island = {0.6, 0.5, 0.55, 0.5};
  EXPECT_NEAR(ThresholdScore(island, LoopThreshold::kSum, 0.4), 2.15, kTight);
  EXPECT_NEAR(ThresholdScore(island, LoopThreshold::kPair, 0.4), 0.6, kTight);
  EXPECT_NEAR(ThresholdScore(island, LoopThreshold::kCalibrated, 0.4), 1.5, kTight);
  EXPECT_NEAR(ThresholdScore(island, LoopThreshold::kCalibrated, 0.0), 12.0, kTight);
  EXPECT_EQ(ThresholdScore({}, LoopThreshold::kSum, 0.4), 0.0);
}

}  // namespace
}  // namespace deja_view
