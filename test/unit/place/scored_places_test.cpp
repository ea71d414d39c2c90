#include "deja_view/place/scored_places.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <vector>

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

/// Images whose words are common and rare, once and often shown, as BowVector allows.
BowVector SkewedWords(std::mt19937_64* rng,
                      std::uint64_t count = ScoredVocabulary()->word_count()) {
  std::vector<WordId> words;
  for (int i = 0; i < 30; ++i) {
    const auto word = static_cast<WordId>((*rng)() % (1 + (*rng)() % count));
    const std::size_t times = (*rng)() % 40 == 0 ? 300 : 1 + (*rng)() % 3;
    words.insert(words.end(), times, word);
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

/// Also where slots are free, and words so many that they are cut into ranges.
TEST_P(ScoredPlacesOf, GivesTheSameForManyAtOnce) {
  ScoringOptions options;
  options.weights = GetParam();
  const auto vocabulary = Vocabulary::FromTree(test::RandomTree(17, 3, 7));
  std::mt19937_64 rng(5);
  ScoredPlaces one_by_one(options, vocabulary);
  ScoredPlaces at_once(options, vocabulary);
  for (int id = 0; id < 3; ++id) {
    const BowVector bow = SkewedWords(&rng, vocabulary->word_count());
    one_by_one.Add(id, bow, 0);
    at_once.Add(id, bow, 0);
  }
  one_by_one.Remove(1, 0);
  at_once.Remove(1, 0);
  std::vector<BowVector> bows;
  std::vector<PackedBow> packed;
  for (int i = 0; i < 300; ++i) {
    bows.push_back(SkewedWords(&rng, vocabulary->word_count()));
    packed.push_back(Pack(bows.back(), at_once.Weigh(bows.back())));
  }
  std::vector<WeighedImage> images;
  for (std::size_t i = 0; i < bows.size(); ++i) {
    one_by_one.Add(3 + static_cast<int>(i), bows[i], 0);
    images.push_back({3 + static_cast<int>(i), &packed[i]});
  }
  at_once.AddAll(images, 0);
  std::size_t found = 0;
  for (WordId word = 0; word < vocabulary->word_count(); ++word) {
    const WeightedBow query = {{word, 1.0}};
    const auto a = one_by_one.Query(query, 1000, 1000);
    const auto b = at_once.Query(query, 1000, 1000);
    ASSERT_EQ(a.size(), b.size()) << word;
    found += a.size();
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_EQ(a[k].id, b[k].id);
      EXPECT_EQ(a[k].score, b[k].score);
    }
  }
  EXPECT_GT(found, 5000U);
}

INSTANTIATE_TEST_SUITE_P(Weightings,
                         ScoredPlacesOf,
                         testing::Values(WordWeighting::kTfidf,
                                         WordWeighting::kPrinted,
                                         WordWeighting::kText,
                                         WordWeighting::kSynonym));

/// All places scored one by one, in single precision, word by word.
class PlainPlaces {
 public:
  explicit PlainPlaces(const ScoredPlaces& places) : places_(places) {}

  void Add(int id, const BowVector& bow, int tag) { images_[id][tag] = places_.Weigh(bow); }
  void Remove(int id, int tag) { images_[id].erase(tag); }

  std::vector<ScoredPlace> Query(const WeightedBow& query, int max_id, std::size_t count) const {
    std::vector<ScoredPlace> found;
    for (const auto& [id, images] : images_) {
      float original = 0;
      float view = -1;
      for (const auto& [tag, words] : images) {
        (tag == 0 ? original : view) = std::max(tag == 0 ? 0.0F : view, Cosine(query, words));
      }
      const double o = double{original};
      const double v = view < 0 ? o : double{view};
      if (id <= max_id && std::max(o, v) > 0) {
        found.push_back({id, o, v, CombineScores(o, v).score});
      }
    }
    std::stable_sort(
        found.begin(), found.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    found.resize(std::min(found.size(), count));
    return found;
  }

 private:
  static float Cosine(const WeightedBow& query, const WeightedBow& words) {
    float sum = 0;
    for (const WeightedWord& w : words) {
      for (const WeightedWord& q : query) {
        sum += q.word == w.word ? static_cast<float>(q.weight) * static_cast<float>(w.weight) : 0;
      }
    }
    return std::min(1.0F, sum);
  }

  const ScoredPlaces& places_;
  std::map<int, std::map<int, WeightedBow>> images_;
};

/// What is skipped would not have been found, whatever was added and removed before.
TEST_P(ScoredPlacesOf, FindsBitForBitWhatScoringAllFinds) {
  ScoringOptions options;
  options.weights = GetParam();
  options.synonym_radius = 118;
  options.synonym_sigma = 60;
  ScoredPlaces places(options, ScoredVocabulary());
  PlainPlaces plain(places);
  std::mt19937_64 rng(11);
  const auto add = [&](int id, int tag) {
    const BowVector bow = SkewedWords(&rng);
    places.Add(id, bow, tag);
    plain.Add(id, bow, tag);
  };
  const auto remove = [&](int id, int tag) {
    places.Remove(id, tag);
    plain.Remove(id, tag);
  };
  const auto expect_same = [&] {
    for (const std::size_t count : {0U, 1U, 7U, 50U, 2000U}) {
      const WeightedBow query = places.Weigh(SkewedWords(&rng));
      const auto found = places.Query(query, 1100, count);
      const auto expected = plain.Query(query, 1100, count);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].id, expected[i].id);
        EXPECT_EQ(found[i].original, expected[i].original);
        EXPECT_EQ(found[i].virtual_view, expected[i].virtual_view);
        EXPECT_EQ(found[i].score, expected[i].score);
      }
    }
  };
  for (int id = 0; id < 1200; ++id) {
    add(id, 0);
  }
  expect_same();
  for (int id = 0; id < 1200; id += 5) {
    add(id, 1);
    add(id, 2);
  }
  expect_same();
  for (int id = 0; id < 1200; id += 4) {
    remove(id, 0);
    remove(id, 2);
    add(id, 3);
  }
  expect_same();
}

TEST(ScoredPlaces, KnowsWordsThatAreFarApart) {
  const auto vocabulary = Vocabulary::FromTree(test::RandomTree(43, 3, 1));
  ScoredPlaces places({}, vocabulary);
  const auto last = static_cast<WordId>(vocabulary->word_count()) - 1;
  ASSERT_GT(last, 0xffffU + 0xffU);
  const BowVector far = CountWords({3, 3 + 0xffffU, last});
  places.Add(1, far, 0);
  places.Add(2, CountWords({4, last - 1}), 0);
  const auto found = places.Query(places.Weigh(far), 10, 10);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].id, 1);
  EXPECT_NEAR(found[0].score, 1.0, 1e-6);
}

TEST(ScoredPlaces, TakesNoMoreRoomForViewsThatComeAndGo) {
  ScoredPlaces places({}, ScoredVocabulary());
  std::mt19937_64 rng(5);
  const BowVector bow = FewRandomWords(&rng);
  places.Add(1, bow, 0);
  const auto come_and_go = [&](int times) {
    for (int i = 0; i < times; ++i) {
      places.Add(1, bow, 1);
      places.Remove(1, 1);
    }
    return places.memory_bytes();
  };
  const std::size_t bytes = come_and_go(1);
  EXPECT_EQ(come_and_go(100), bytes);
}

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
