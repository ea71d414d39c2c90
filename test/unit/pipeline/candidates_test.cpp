#include "candidates.hpp"

#include "deja_view/base/angles.hpp"

#include "second.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// The keyframe's index is its time in seconds.
RetrievedPlace Place(int keyframe, double score, int sequence = 0) {
  return {keyframe, score, sequence, keyframe * kSecond};
}

std::vector<int> Keyframes(const std::vector<Candidate>& candidates) {
  std::vector<int> keyframes;
  for (const Candidate& candidate : candidates) {
    keyframes.push_back(candidate.keyframe);
  }
  return keyframes;
}

CandidateOptions Options() {
  CandidateOptions options;
  options.island_gap_s = 1.5;
  options.members_per_island = 2;
  return options;
}

TEST(CandidatesFromIslands, TakesTheBestOfEveryIslandFirst) {
  // Three islands: {10, 11, 12}, {30}, {50, 51}; the sums are 0.6, 0.5 and 0.55.
  const auto candidates = CandidatesFromIslands({Place(30, 0.5),
                                                 Place(12, 0.1),
                                                 Place(50, 0.25),
                                                 Place(10, 0.2),
                                                 Place(51, 0.3),
                                                 Place(11, 0.3)},
                                                Options());
  EXPECT_THAT(Keyframes(candidates), ElementsAre(11, 51, 30, 10, 50));
  EXPECT_EQ(candidates[0].score, 0.3);
  EXPECT_EQ(candidates[2].score, 0.5);
}

TEST(CandidatesFromIslands, AGapOrANewSequenceEndsAnIsland) {
  CandidateOptions options = Options();
  options.members_per_island = 1;
  EXPECT_THAT(Keyframes(CandidatesFromIslands({Place(1, 0.2), Place(2, 0.1)}, options)),
              ElementsAre(1));
  EXPECT_THAT(Keyframes(CandidatesFromIslands({Place(1, 0.2), Place(3, 0.1)}, options)),
              ElementsAre(1, 3));
  EXPECT_THAT(Keyframes(CandidatesFromIslands({Place(1, 0.2), Place(2, 0.1, 1)}, options)),
              ElementsAre(1, 2));
  options.island_gap_s = 2.0;
  EXPECT_THAT(Keyframes(CandidatesFromIslands({Place(1, 0.2), Place(3, 0.1)}, options)),
              ElementsAre(1));
}

TEST(CandidatesFromIslands, TiesGoToTheLowerIndex) {
  EXPECT_THAT(Keyframes(CandidatesFromIslands(
                  {Place(9, 0.5), Place(20, 0.5), Place(5, 0.5), Place(4, 0.5)}, Options())),
              ElementsAre(4, 9, 20, 5));
}

TEST(CandidatesFromIslands, NothingComesOfNothing) {
  EXPECT_THAT(CandidatesFromIslands({}, Options()), IsEmpty());
}

NearbyPlace At(int keyframe, double x, double yaw_deg) {
  const Eigen::Quaterniond forward =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX());
  return {keyframe, {FromYaw(ToRadians(yaw_deg)) * forward, {x, 0, 0}}};
}

CandidateOptions NearbyOptions(int count) {
  CandidateOptions options = Options();
  options.nearby = count;
  options.nearby_distance_m = 2;
  options.nearby_angle_deg = 40;
  return options;
}

TEST(CandidatesNearby, NearestInDistanceAndAngleFirst) {
  const CandidateOptions options = NearbyOptions(3);
  const NearbyPlace here = At(100, 0, 0);
  // Costs: distance / 2 + angle / 40.
  const std::vector<NearbyPlace> places = {
      At(0, 1.0, 0), At(1, 0.2, 30), At(2, 0.2, 10), At(3, 1.8, 38), At(4, 0.1, 0)};
  const auto found = CandidatesNearby(places, here, options);
  EXPECT_THAT(Keyframes(found), ElementsAre(4, 2, 0));
  EXPECT_EQ(found[0].score, 0) << "position is no place score";
}

TEST(CandidatesNearby, LeavesOutWhatIsFarOrLooksElsewhere) {
  CandidateOptions options = NearbyOptions(10);
  const NearbyPlace here = At(100, 0, 0);
  EXPECT_THAT(Keyframes(CandidatesNearby(
                  {At(0, 2.1, 0), At(1, -2.1, 0), At(2, 0, 41), At(3, 0, 180), At(4, 1.9, 39)},
                  here,
                  options)),
              ElementsAre(4));
  options.nearby = 0;
  EXPECT_THAT(CandidatesNearby({At(4, 0, 0)}, here, options), IsEmpty());
}

TEST(CandidatesNearby, TiesGoToTheLowerIndex) {
  CandidateOptions options = Options();
  options.nearby = 2;
  EXPECT_THAT(
      Keyframes(CandidatesNearby({At(7, 1, 0), At(3, 1, 0), At(5, -1, 0)}, At(100, 0, 0), options)),
      ElementsAre(3, 5));
}

TEST(MergeCandidates, AlternatesAndRepeatsNothing) {
  const std::vector<Candidate> retrieved = {{1, 0.9}, {2, 0.8}, {3, 0.7}};
  const std::vector<Candidate> nearby = {{8, 0}, {2, 0}};
  CandidateOptions options = Options();
  options.max_verified = 10;
  const auto lost = MergeCandidates(retrieved, nearby, false, options);
  EXPECT_THAT(Keyframes(lost), ElementsAre(1, 8, 2, 3));
  const auto localised = MergeCandidates(retrieved, nearby, true, options);
  EXPECT_THAT(Keyframes(localised), ElementsAre(8, 1, 2, 3));
  EXPECT_EQ(localised[0].score, 0);
  EXPECT_EQ(localised[2].score, 0.8) << "found by position, but retrieved as well";
  options.max_verified = 2;
  EXPECT_THAT(Keyframes(MergeCandidates(retrieved, nearby, false, options)), ElementsAre(1, 8));
  EXPECT_THAT(MergeCandidates({}, {}, true, options), IsEmpty());
}

}  // namespace
}  // namespace deja_view
