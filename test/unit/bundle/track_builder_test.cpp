#include "track_builder.hpp"

#include <gmock/gmock.h>

namespace deja_view::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Images of so many keypoints each, without tracks.
BundleProblem Images(int count, std::size_t keypoints) {
  BundleProblem problem;
  problem.images.resize(static_cast<std::size_t>(count));
  for (BundleImage& image : problem.images) {
    image.keypoints.resize(keypoints);
    image.descriptors.resize(keypoints);
    image.track_ids.resize(keypoints, -1);
  }
  return problem;
}

TEST(BuildTracks, JoinsMatchesAcrossImages) {
  const BundleProblem problem = Images(3, 2);
  const std::vector<KeypointMatch> matches = {{{1, 1}, {2, 0}, 5}, {{0, 0}, {1, 1}, 9}};
  EXPECT_THAT(BuildTracks(problem, matches),
              ElementsAre(ElementsAre(
                  BundleObservation{0, 0}, BundleObservation{1, 1}, BundleObservation{2, 0})));
}

TEST(BuildTracks, LeavesOutTheLessAlikeOfTwoMatchesThatContradict) {
  const BundleProblem problem = Images(2, 2);
  const std::vector<KeypointMatch> matches = {{{0, 0}, {1, 1}, 9}, {{0, 0}, {1, 0}, 5}};
  EXPECT_THAT(BuildTracks(problem, matches),
              ElementsAre(ElementsAre(BundleObservation{0, 0}, BundleObservation{1, 0})));
}

TEST(BuildTracks, FollowsTheViosTracksFirst) {
  BundleProblem problem = Images(3, 2);
  problem.images[0].track_ids[1] = 7;
  problem.images[2].track_ids[0] = 7;
  // Contradicts the track, however alike.
  const std::vector<KeypointMatch> matches = {{{0, 1}, {2, 1}, 0}};
  EXPECT_THAT(BuildTracks(problem, matches),
              ElementsAre(ElementsAre(BundleObservation{0, 1}, BundleObservation{2, 0})));
}

TEST(BuildTracks, MakesNoTrackOfOneKeypoint) {
  EXPECT_THAT(BuildTracks(Images(3, 2), {}), IsEmpty());
}

}  // namespace
}  // namespace deja_view::internal
