#include "deja_view/place/scored_places.hpp"

#include <random>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

std::shared_ptr<const Vocabulary> ScoredVocabulary() {
  static const auto vocabulary = Vocabulary::FromTree(test::RandomTree(5, 3, 7));
  return vocabulary;
}

BowVector FewRandomWords(std::mt19937_64* rng) {
  std::vector<WordId> words;
  std::uniform_int_distribution<WordId> word(
      0, static_cast<WordId>(ScoredVocabulary()->word_count()) - 1);
  for (int i = 0; i < 40; ++i) {
    words.push_back(word(*rng));
  }
  return CountWords(words);
}

class ScoredPlacesOf : public testing::TestWithParam<WordWeighting> {};

/// The index against the plain functions of word_scoring.hpp.
TEST_P(ScoredPlacesOf, GivesWhatTheEquationsGive) {
  ScoringOptions options;
  options.weights = GetParam();
  options.synonym_radius = 118;  // of random centroids, some are this near
  options.synonym_sigma = 60;
  const auto vocabulary = ScoredVocabulary();
  ScoredPlaces places(options, vocabulary);
  std::mt19937_64 rng(3);
  std::vector<BowVector> originals;
  std::vector<BowVector> views;
  for (int id = 0; id < 20; ++id) {
    originals.push_back(FewRandomWords(&rng));
    views.push_back(FewRandomWords(&rng));
    places.Add(id, originals.back(), 0);
    if (id % 2 == 0) {
      places.Add(id, views.back(), 1);
    }
  }
  const SynonymKernel kernel(vocabulary, options.synonym_radius, options.synonym_sigma);
  const auto weigh = [&](const BowVector& bow) {
    return WeighWords(
        TfIdf(bow, [&](WordId w) { return double{vocabulary->Idf(w)}; }), GetParam(), &kernel);
  };
  const BowVector query = FewRandomWords(&rng);
  const auto found = places.Query(places.Weigh(query), 18, 30);
  ASSERT_GT(found.size(), 3U);
  for (const ScoredPlace& place : found) {
    const auto id = static_cast<std::size_t>(place.id);
    EXPECT_LE(place.id, 18);
    const double original = CosineSimilarity(weigh(query), weigh(originals[id]));
    const double view = id % 2 == 0 ? CosineSimilarity(weigh(query), weigh(views[id])) : original;
    EXPECT_NEAR(place.original, original, 1e-6);
    EXPECT_NEAR(place.virtual_view, view, 1e-6);
    EXPECT_NEAR(place.score, CombineScores(original, view).score, 1e-6);
  }
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_GE(found[i - 1].score, found[i].score);
  }
}

INSTANTIATE_TEST_SUITE_P(Weightings,
                         ScoredPlacesOf,
                         testing::Values(WordWeighting::kTfidf,
                                         WordWeighting::kPrinted,
                                         WordWeighting::kText,
                                         WordWeighting::kSynonym));

TEST(ScoredPlaces, ForgetsWhatIsRemoved) {
  ScoredPlaces places({}, ScoredVocabulary());
  std::mt19937_64 rng(5);
  const BowVector bow = FewRandomWords(&rng);
  places.Add(4, bow, 0);
  places.Add(5, bow, 0);
  places.Remove(4, 0);
  const auto found = places.Query(places.Weigh(bow), 10, 10);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].id, 5);
  EXPECT_NEAR(found[0].score, 1.0, 1e-6);
}

TEST(ScoredPlaces, OfEqualsTheOldestComeFirst) {
  ScoredPlaces places({}, ScoredVocabulary());
  std::mt19937_64 rng(5);
  const BowVector bow = FewRandomWords(&rng);
  for (const int id : {40, 7, 31, 22, 5, 60, 13, 50, 2, 9}) {
    places.Add(id, bow, 0);
  }
  const auto found = places.Query(places.Weigh(bow), 45, 3);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].id, 2);
  EXPECT_EQ(found[1].id, 5);
  EXPECT_EQ(found[2].id, 7);
}

TEST(ScoredPlaces, OptionsAreChecked) {
  ScoringOptions options;
  EXPECT_TRUE(options.Validate().empty());
  options.alpha = -1;
  options.neighbours = 0;
  EXPECT_EQ(options.Validate().size(), 2U);
}

}  // namespace
}  // namespace deja_view
