#include "deja_view/vocabulary/vocabulary_training.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <cmath>
#include <random>
#include <set>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

// Images that see `landmarks` again and again, each a little different.
std::vector<std::vector<Descriptor>> MakeImages(int images, int landmarks, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<Descriptor> world;
  for (int i = 0; i < landmarks; ++i) {
    world.push_back(test::RandomDescriptor(&rng));
  }
  std::vector<std::vector<Descriptor>> result(images);
  for (auto& image : result) {
    for (int i = 0; i < 100; ++i) {
      image.push_back(test::Disturb(world[rng() % world.size()], 10, &rng));
    }
  }
  return result;
}

TrainOptions SmallOptions() {
  TrainOptions options;
  options.k = 6;
  options.levels = 3;
  return options;
}

TEST(TrainVocabulary, DoesNotDependOnThreads) {
  const auto images = MakeImages(800, 400, 1);  // 80,000 descriptors: a big node and small ones
  TrainOptions options = SmallOptions();
  options.threads = 1;
  const VocabularyTree one = TrainVocabulary(images, options);
  options.threads = 3;
  EXPECT_EQ(TrainVocabulary(images, options).nodes, one.nodes);
}

TEST(TrainVocabulary, SeedsMatter) {
  const auto images = MakeImages(20, 100, 1);
  TrainOptions options = SmallOptions();
  const VocabularyTree one = TrainVocabulary(images, options);
  EXPECT_EQ(TrainVocabulary(images, options).nodes, one.nodes);
  options.seed = 2;
  EXPECT_NE(TrainVocabulary(images, options).nodes, one.nodes);
}

TEST(TrainVocabulary, WordsRecogniseLandmarks) {
  const auto images = MakeImages(100, 50, 1);
  const auto vocabulary = Vocabulary::FromTree(TrainVocabulary(images, SmallOptions()));
  // The same landmark, disturbed anew, mostly falls into the same word.
  std::mt19937_64 rng(9);
  int same = 0;
  for (const Descriptor& descriptor : images[0]) {
    same += vocabulary->Word(descriptor) == vocabulary->Word(test::Disturb(descriptor, 10, &rng));
  }
  EXPECT_GT(same, 60);
}

TEST(TrainVocabulary, KeepsWithinItsLimits) {
  const auto images = MakeImages(50, 500, 1);
  TrainOptions options = SmallOptions();
  const auto full = Vocabulary::FromTree(TrainVocabulary(images, options));
  EXPECT_EQ(full->levels(), 3);
  EXPECT_GT(full->word_count(), 150U);
  EXPECT_LE(full->word_count(), 216U);
  options.levels = 8;
  options.max_words = 120;
  const VocabularyTree limited = TrainVocabulary(images, options);
  const auto vocabulary = Vocabulary::FromTree(limited);
  EXPECT_LE(vocabulary->word_count(), 120U);
  EXPECT_GT(vocabulary->word_count(), 114U);
  // Written without what only foreign files need.
  EXPECT_EQ(vocabulary->ToTree().nodes, limited.nodes);
}

TEST(TrainVocabulary, WeightsAreInverseDocumentFrequencies) {
  std::mt19937_64 rng(3);
  const Descriptor everywhere = test::RandomDescriptor(&rng);
  const Descriptor once = test::RandomDescriptor(&rng);
  const std::vector<std::vector<Descriptor>> images = {
      {everywhere, everywhere, once}, {everywhere}, {everywhere}, {everywhere}};
  const auto vocabulary = Vocabulary::FromTree(TrainVocabulary(images, TrainOptions{}));
  ASSERT_EQ(vocabulary->word_count(), 2U);
  EXPECT_FLOAT_EQ(vocabulary->Idf(vocabulary->Word(everywhere)), 0.0F);
  EXPECT_FLOAT_EQ(vocabulary->Idf(vocabulary->Word(once)), std::log(4.0F));
}

TEST(TrainVocabulary, TakesASingleDescriptor) {
  const auto vocabulary = Vocabulary::FromTree(TrainVocabulary({{Descriptor{}}}, TrainOptions{}));
  EXPECT_EQ(vocabulary->word_count(), 1U);
}

TEST(TrainVocabulary, TellsItsProgress) {
  std::vector<std::size_t> done;
  TrainVocabulary(MakeImages(20, 100, 1), SmallOptions(), [&](std::size_t d, std::size_t total) {
    EXPECT_LE(d, total);
    EXPECT_TRUE(done.empty() || d > done.back());
    done.push_back(d);
  });
  EXPECT_GE(done.size(), 3U);
}

TEST(TrainVocabulary, RefusesNothingToLearnFrom) {
  EXPECT_THROW(TrainVocabulary({}, TrainOptions{}), InputError);
  EXPECT_THROW(TrainVocabulary({{}, {}}, TrainOptions{}), InputError);
}

TEST(TrainOptions, ListsAllViolations) {
  EXPECT_TRUE(TrainOptions{}.Validate().empty());
  TrainOptions options;
  options.k = 1;
  options.levels = 0;
  options.iterations = 0;
  options.descriptor_name = "sift";
  EXPECT_EQ(options.Validate().size(), 4U);
  EXPECT_THROW(TrainVocabulary({{Descriptor{}}}, options), CheckError);
}

}  // namespace
}  // namespace deja_view
