#include "place_finder.hpp"

#include "deja_view/base/check.hpp"

#include <random>

#include "random_vocabulary.hpp"
#include "second.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

std::shared_ptr<const Vocabulary> MakeVocabulary() {
  static const auto vocabulary = Vocabulary::FromTree(test::RandomTree(5, 3, 7));
  return vocabulary;
}

/// Words of a place; images of different places share few.
BowVector WordsOf(int place) {
  std::mt19937_64 rng(static_cast<std::uint64_t>(place) + 100);
  std::vector<WordId> words;
  for (int i = 0; i < 15; ++i) {
    words.push_back(static_cast<WordId>(rng() % MakeVocabulary()->word_count()));
  }
  return CountWords(words);
}

NearbyPlace At(int keyframe, double x) {
  return {keyframe, {Eigen::Quaterniond::Identity(), {x, 0, 0}}};
}

std::vector<int> Keyframes(const FoundPlaces& found) {
  std::vector<int> keyframes;
  for (const Candidate& candidate : found.candidates) {
    keyframes.push_back(candidate.keyframe);
  }
  return keyframes;
}

/// Both ways of scoring.
class PlaceFinderOf : public testing::TestWithParam<bool> {
 protected:
  PlaceFinderOf() {
    scoring_.is_on = GetParam();
    scoring_.threshold = LoopThreshold::kPair;
    candidates_.min_age_s = 10;
  }

  PlaceFinder Make() const { return {place_, scoring_, candidates_, MakeVocabulary()}; }

  /// Keyframes 0, 2, 4, ... 18 of sequence 0 are places, keyframe i at i seconds.
  PlaceFinder WithPlaces() const {
    PlaceFinder finder = Make();
    for (int i = 0; i < 20; i += 2) {
      finder.Add(i, 0, i * kSecond, Look(i));
    }
    return finder;
  }

  ImageWords Look(int place) const {
    ImageWords words;
    words.bow = WordsOf(place);
    if (scoring_.is_on) {
      words.weighted = ScoredPlaces(scoring_, MakeVocabulary()).Weigh(words.bow);
    }
    return words;
  }

  /// An image of keyframe `place`'s words at `seconds`, far from all places.
  FoundPlaces Find(const PlaceFinder& finder, int place, int seconds, int sequence = 0) const {
    PlaceQuestion question;
    question.sequence = sequence;
    question.stamp_ns = seconds * kSecond;
    question.here = At(100, 1000);
    return finder.Find(question, Look(place));
  }

  PlaceDatabaseOptions place_;
  ScoringOptions scoring_;
  CandidateOptions candidates_;
};

TEST_P(PlaceFinderOf, FindsWhatLooksAlike) {
  const PlaceFinder finder = WithPlaces();
  EXPECT_EQ(finder.size(), 10);
  for (const int place : {0, 6, 18}) {
    const FoundPlaces found = Find(finder, place, 60);
    ASSERT_FALSE(found.candidates.empty());
    EXPECT_EQ(found.candidates.front().keyframe, place);
    EXPECT_NEAR(found.candidates.front().score, 1.0, 1e-6) << "the same image";
    ASSERT_TRUE(found.best);
    EXPECT_EQ(found.best->old, place);
  }
}

TEST_P(PlaceFinderOf, OnlyOldPlacesOfTheSameSequenceCount) {
  const PlaceFinder finder = WithPlaces();
  EXPECT_THAT(Keyframes(Find(finder, 6, 16)), testing::Contains(6)) << "10 s old";
  EXPECT_THAT(Keyframes(Find(finder, 6, 15)), Each(testing::Le(4)));
  EXPECT_THAT(Keyframes(Find(finder, 6, 15, 1)), testing::Contains(6)) << "another sequence";
  const FoundPlaces none = Find(finder, 6, 9);
  EXPECT_THAT(none.candidates, IsEmpty());
  EXPECT_FALSE(none.best);
  EXPECT_THAT(Find(Make(), 6, 60).candidates, IsEmpty());
}

TEST_P(PlaceFinderOf, FindsWhatIsNearAndOldEnough) {
  const PlaceFinder finder = WithPlaces();
  PlaceQuestion question;
  question.stamp_ns = 24 * kSecond;
  question.here = At(100, 5.0);
  question.around = {At(0, 3.1), At(2, 4.9), At(4, 9.0), At(16, 5.0)};
  question.is_localised = true;
  candidates_.nearby = 1;
  const FoundPlaces found = Make().Find(question, Look(77));
  EXPECT_THAT(found.candidates, IsEmpty()) << "nothing is old enough without places";
  const std::vector<int> keyframes = Keyframes(WithPlaces().Find(question, Look(77)));
  ASSERT_FALSE(keyframes.empty());
  EXPECT_EQ(keyframes.front(), 2) << "16 is nearer, but only 8 s old";
}

TEST_P(PlaceFinderOf, AViewSpeaksForItsKeyframe) {
  PlaceFinder finder = WithPlaces();
  finder.AddView(4, 7, WordsOf(55));
  EXPECT_EQ(finder.size(), 10) << "a view is no place of its own";
  const FoundPlaces found = Find(finder, 55, 60);
  ASSERT_FALSE(found.candidates.empty());
  EXPECT_EQ(found.candidates.front().keyframe, 4);
  EXPECT_GT(finder.view_memory_bytes(), 0U);
  EXPECT_LT(finder.view_memory_bytes(), finder.memory_bytes());
  finder.RemoveView(4, 7);
  const FoundPlaces gone = Find(finder, 55, 60);
  EXPECT_LT(gone.best ? gone.best->score : 0, 0.9);
  finder.AddView(4, 7, WordsOf(55));
  EXPECT_EQ(Find(finder, 55, 60).best->old, 4);
}

TEST_P(PlaceFinderOf, ClearForgetsAll) {
  PlaceFinder finder = WithPlaces();
  finder.AddView(4, 0, WordsOf(55));
  finder.Clear();
  EXPECT_EQ(finder.size(), 0);
  EXPECT_EQ(finder.view_memory_bytes(), 0U);
  EXPECT_THAT(Find(finder, 6, 60).candidates, IsEmpty());
  finder.Add(3, 0, 0, Look(3));
  EXPECT_EQ(Find(finder, 3, 60).best->old, 3);
}

TEST_P(PlaceFinderOf, PlacesComeInTheirOrder) {
  PlaceFinder finder = WithPlaces();
  EXPECT_THROW(finder.Add(18, 0, 20 * kSecond, Look(1)), CheckError);
}

INSTANTIATE_TEST_SUITE_P(Scores, PlaceFinderOf, testing::Values(false, true));

class ScoredPlaceFinder : public PlaceFinderOf {};

TEST_P(ScoredPlaceFinder, TheOwnScoreIsTakenAgainstTheNewestPredecessors) {
  scoring_.threshold = LoopThreshold::kCalibrated;
  PlaceFinder finder = WithPlaces();
  const double stranger = Find(finder, 6, 60).best->score;
  EXPECT_GT(stranger, 2.0) << "over the least own score";
  finder.Pass(Look(6));
  EXPECT_NEAR(Find(finder, 6, 60).best->score, 1.0, 1e-6) << "as alike as the image before";
  for (int i = 0; i < 3; ++i) {
    finder.Pass(Look(90 + i));
  }
  EXPECT_GT(Find(finder, 6, 60).best->score, 1.5) << "three predecessors and no more";
}

TEST_P(ScoredPlaceFinder, IslandsBelowTheThresholdAreNoCandidates) {
  const FoundPlaces all = Find(WithPlaces(), 6, 60);
  EXPECT_GT(all.candidates.size(), 1U);
  scoring_.r = 0.9;
  const FoundPlaces some = Find(WithPlaces(), 6, 60);
  EXPECT_THAT(Keyframes(some), ElementsAre(6));
  EXPECT_EQ(some.best->score, all.best->score) << "told whether or not it suffices";
  scoring_.r = 1.1;
  EXPECT_THAT(Find(WithPlaces(), 6, 60).candidates, IsEmpty());
}

TEST_P(ScoredPlaceFinder, WithoutAThresholdAllAreOfferedThatL1WouldOffer) {
  scoring_.neighbours = 2;
  const FoundPlaces all = Find(WithPlaces(), 6, 60);
  scoring_.r = 1e-9;
  const FoundPlaces judged = Find(WithPlaces(), 6, 60);
  scoring_.is_on = false;
  EXPECT_EQ(all.candidates.size(), Find(WithPlaces(), 6, 60).candidates.size());
  EXPECT_EQ(judged.candidates.size(), 2U);
  EXPECT_EQ(judged.best->score, all.best->score) << "the same neighbours are judged";
}

INSTANTIATE_TEST_SUITE_P(Scores, ScoredPlaceFinder, testing::Values(true));

}  // namespace
}  // namespace deja_view
