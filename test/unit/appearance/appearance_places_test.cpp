#include "deja_view/appearance/appearance_places.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/brief_extractor.hpp"

#include <algorithm>
#include <utility>

#include "random_vocabulary.hpp"
#include "synthetic_image.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr int kLap = 12;

/// Windows that wander over a large picture, twice the same way, two pixels off the second time.
std::vector<Features> TwoLaps() {
  const cv::Mat world = test::SyntheticImage(320 + kLap * 80, 260, 1);
  const BriefExtractor extractor;
  std::vector<Features> images;
  for (int i = 0; i < 2 * kLap; ++i) {
    const int offset = i < kLap ? 0 : 2;
    images.push_back(
        extractor.Extract(world(cv::Rect(80 * (i % kLap) + offset, offset, 320, 240)).clone()));
  }
  return images;
}

std::vector<AppearanceMatch> FindAll(const AppearancePlacesOptions& options) {
  AppearancePlaces places(options, Vocabulary::FromTree(test::RandomTree(10, 3, 7)));
  std::vector<AppearanceMatch> found;
  for (Features& features : TwoLaps()) {
    found.push_back(places.Add(std::move(features)));
  }
  return found;
}

AppearancePlacesOptions ShortGap() {
  AppearancePlacesOptions options;
  options.min_gap = 8;
  options.island_gap = 1;
  options.two_view.max_iterations = 100;  // of shifts, which anything finds
  return options;
}

TEST(AppearancePlaces, RecognisesTheSecondLap) {
  const auto found = FindAll(ShortGap());
  for (int i = 0; i < 2 * kLap; ++i) {
    const AppearanceMatch& match = found[static_cast<std::size_t>(i)];
    EXPECT_LE(match.id, std::max(-1, i - 8)) << i;
    if (i < 8) {
      EXPECT_EQ(match.id, -1) << i;
    } else if (i < kLap) {
      EXPECT_LT(match.inliers, 30) << i;
    } else {
      EXPECT_EQ(match.id, i - kLap) << i;
      EXPECT_GT(match.inliers, 100) << i;
      EXPECT_EQ(match.score, match.inliers);
    }
  }
}

TEST(AppearancePlaces, SameOnAnyNumberOfThreads) {
  AppearancePlacesOptions options = ShortGap();
  const auto one = FindAll(options);
  options.threads = 4;
  const auto four = FindAll(options);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].id, four[i].id);
    EXPECT_EQ(one[i].inliers, four[i].inliers);
    EXPECT_EQ(one[i].similarity, four[i].similarity);
  }
}

TEST(AppearancePlaces, ConsistencyNeedsMatchesBefore) {
  AppearancePlacesOptions options = ShortGap();
  options.consistency = 2;
  options.consistency_gap = 1;
  const auto found = FindAll(options);
  EXPECT_EQ(found[kLap].score, 0) << "the first of the lap has none before it";
  EXPECT_EQ(found[kLap + 1].score, 0);
  for (std::size_t i = kLap + 2; i < found.size(); ++i) {
    EXPECT_EQ(found[i].score,
              std::min({found[i].inliers, found[i - 1].inliers, found[i - 2].inliers}));
  }
}

TEST(AppearancePlaces, IslandsByHand) {
  const auto islands =
      GroupIslands({{20, 0, 0.5}, {3, 0, 0.25}, {5, 0, 0.375}, {4, 0, 0.125}, {8, 0, 0.125}}, 2);
  const std::vector<PlaceIsland> expected = {{5, 0.375, 0.75}, {20, 0.5, 0.5}, {8, 0.125, 0.125}};
  EXPECT_EQ(islands, expected);
  EXPECT_TRUE(GroupIslands({}, 1).empty());
}

TEST(AppearancePlaces, OptionsAreChecked) {
  AppearancePlacesOptions options;
  EXPECT_TRUE(options.Validate().empty());
  options.min_gap = 0;
  options.two_view.max_error_px = 0;
  EXPECT_EQ(options.Validate().size(), 2U);
  const auto vocabulary = Vocabulary::FromTree(test::RandomTree(4, 2, 1));
  EXPECT_THROW(AppearancePlaces(options, vocabulary), CheckError);
}

}  // namespace
}  // namespace deja_view
