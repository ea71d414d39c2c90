#include "deja_view/lab/evaluation/judge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;

/// A camera that looks along the body's x.
const Rigid3 kExtrinsic{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0, 0, 0}};

std::int64_t Seconds(double seconds) {
  return static_cast<std::int64_t>(seconds * 1e9);
}

Rigid3 Pose(double x, double y = 0) {
  return {Eigen::Quaterniond::Identity(), {x, y, 0}};
}

/// On paper: six keyframes along x, 10 s apart, all looking along x. 0 to 2 go away (x = 0, 5, 10),
/// 3 to 5 come back (x = 10, 5, 0.5) one metre to the side. Keyframes 3, 4 and 5 see 2, 1 and 0
/// again: at sqrt(0 + 1) = 1, 1 and sqrt(0.25 + 1) = 1.12 m, less than 2 m, and 10, 30 and 50 s
/// later. All others are 4.5 m apart or more.
class JudgeFlightTest : public ::testing::Test {
 protected:
  JudgeFlightTest() {
    const double x[] = {0, 5, 10, 10, 5, 0.5};
    for (int i = 0; i < 6; ++i) {
      FlownKeyframe keyframe;
      keyframe.stamp_ns = Seconds(10.0 * i);
      keyframe.T_M_B = keyframe.T_W_B = Pose(x[i], i < 3 ? 0 : 1);
      truth_.own.stamps_ns.push_back(keyframe.stamp_ns);
      truth_.own.poses.push_back(keyframe.T_M_B);
      flight_.keyframes.push_back(keyframe);
    }
  }

  /// A loop whose relative pose is off by `error_m`.
  void AddLoop(int current, int old, double score, double error_m = 0, bool is_accepted = true) {
    const auto pose = [&](int i) { return truth_.own.poses[static_cast<std::size_t>(i)]; };
    Rigid3 relative = pose(old).Inverse() * pose(current);
    relative.t.y() += error_m;
    flight_.loops.push_back({old, current, relative, score, false, is_accepted});
  }
  JudgedFlight Judge() const { return JudgeFlight(flight_, truth_, kExtrinsic); }

  Flight flight_;
  FlightTruth truth_;
};

TEST_F(JudgeFlightTest, CountsPrecisionAndRecall) {
  AddLoop(3, 2, 0.9);
  AddLoop(4, 1, 0.8, 0.6);  // 0.6 m off, more than 0.5 m
  AddLoop(4, 1, 0.7);
  AddLoop(5, 0, 0.6, 0, false);  // right, but refused
  flight_.loops[2].is_virtual = true;
  const JudgedFlight judged = Judge();
  EXPECT_THAT(
      judged.verdicts,
      ElementsAre(Verdict::kCorrect, Verdict::kWrong, Verdict::kCorrect, Verdict::kCorrect));
  EXPECT_EQ(judged.score.accepted, 3);
  EXPECT_EQ(judged.score.correct, 2);
  EXPECT_DOUBLE_EQ(judged.score.precision(), 2.0 / 3);
  EXPECT_EQ(judged.score.revisits, 3);
  EXPECT_EQ(judged.score.revisits_found, 2);
  EXPECT_DOUBLE_EQ(judged.score.recall(), 2.0 / 3);
  EXPECT_EQ(judged.virtual_loops, 1);
  EXPECT_EQ(judged.virtual_correct, 1);
  // Only the loop of score 0.9 is free of the wrong one of 0.8: one of three revisits.
  EXPECT_DOUBLE_EQ(judged.recall_at_precision_1, 1.0 / 3);
}

TEST_F(JudgeFlightTest, RecallsAKeyframeOnce) {
  AddLoop(3, 2, 0.9);
  AddLoop(3, 2, 0.8);
  AddLoop(3, 2, 0.7);
  AddLoop(2, 1, 0.6);  // the right pose, but not a revisit: 5 m away
  const JudgedFlight judged = Judge();
  EXPECT_EQ(judged.score.correct, 4);
  EXPECT_DOUBLE_EQ(judged.score.recall(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(judged.recall_at_precision_1, 1.0 / 3);
}

TEST_F(JudgeFlightTest, SweepsTheScoresOfTheBestPlaces) {
  // The best place of each keyframe but the first: of 3 and 5 it is right, of the others not.
  flight_.detections = {{0, 1, 0.10}, {0, 2, 0.20}, {2, 3, 0.80}, {0, 4, 0.40}, {0, 5, 0.30}};
  const JudgedFlight judged = Judge();
  ASSERT_EQ(judged.decisions.size(), 5U);
  EXPECT_FALSE(judged.decisions[0]->is_correct);
  EXPECT_FALSE(judged.decisions[0]->is_revisit);
  EXPECT_TRUE(judged.decisions[2]->is_correct);
  EXPECT_FALSE(judged.decisions[3]->is_correct);
  EXPECT_TRUE(judged.decisions[3]->is_revisit);
  // r     0.8  0.4  0.3  0.2  0.1
  // found   1    2    3    4    5
  // right   1    1    2    2    2     of 3 revisits
  ASSERT_EQ(judged.detections.size(), 5U);
  EXPECT_DOUBLE_EQ(judged.detections[0].precision, 1.0);
  EXPECT_DOUBLE_EQ(judged.detections[0].recall, 1.0 / 3);
  EXPECT_DOUBLE_EQ(judged.detections[1].precision, 1.0 / 2);
  EXPECT_DOUBLE_EQ(judged.detections[2].precision, 2.0 / 3);
  EXPECT_DOUBLE_EQ(judged.detections[2].recall, 2.0 / 3);
  EXPECT_DOUBLE_EQ(judged.detections[4].precision, 2.0 / 5);
}

TEST_F(JudgeFlightTest, LeavesOutWhatTheTruthDoesNotCover) {
  AddLoop(5, 0, 0.9);
  flight_.detections = {{0, 5, 0.9}};
  truth_.own.stamps_ns.pop_back();  // keyframe 5 is later than the truth's end
  truth_.own.poses.pop_back();
  const JudgedFlight judged = Judge();
  EXPECT_THAT(judged.verdicts, ElementsAre(Verdict::kUnknown));
  EXPECT_EQ(judged.score.judged, 0);
  EXPECT_EQ(judged.score.revisits, 2);
  EXPECT_FALSE(judged.decisions[0]);
  EXPECT_TRUE(judged.detections.empty());
  EXPECT_EQ(judged.ape->errors.size(), 5U);
}

TEST_F(JudgeFlightTest, InterpolatesTheTruthOverATenthOfASecond) {
  truth_.own.stamps_ns[1] += Seconds(0.05);
  const auto has_truth = [&] { return Judge().keyframes[1].T_truth_B.has_value(); };
  EXPECT_FALSE(has_truth()) << "its neighbours are 10 s apart";
  truth_.own.stamps_ns.insert(truth_.own.stamps_ns.begin() + 1, Seconds(9.95));
  truth_.own.poses.insert(truth_.own.poses.begin() + 1, Pose(4, 0));
  ASSERT_TRUE(has_truth()) << "halfway between 9.95 and 10.05 s";
  EXPECT_NEAR(Judge().keyframes[1].T_truth_B->t.x(), 4.5, 1e-12);
}

TEST_F(JudgeFlightTest, MeasuresPositionErrors) {
  // A world that is turned and moved is taken out by the alignment.
  const Rigid3 T_M_truth{FromYaw(1.0), {3, -2, 1}};
  for (std::size_t i = 0; i < 6; ++i) {
    flight_.keyframes[i].T_M_B = T_M_truth * truth_.own.poses[i];
  }
  EXPECT_LT(Judge().ape->max, 1e-12);
  EXPECT_LT(Judge().vio_ape->max, 1e-12);
  // A square of 2 m whose corners are lifted and lowered by h in turn can't be turned back into the
  // plane: the best plane is the square's own, so that every error is h.
  flight_.keyframes.resize(4);
  const double corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (std::size_t i = 0; i < 4; ++i) {
    truth_.own.poses[i] = Pose(corners[i][0], corners[i][1]);
    flight_.keyframes[i].T_W_B = truth_.own.poses[i];
    flight_.keyframes[i].T_W_B.t.z() = i % 2 == 0 ? 0.25 : -0.25;
    flight_.keyframes[i].T_M_B = truth_.own.poses[i];
  }
  const JudgedFlight judged = Judge();
  EXPECT_NEAR(judged.vio_ape->rmse, 0.25, 1e-12);
  EXPECT_NEAR(judged.vio_ape->mean, 0.25, 1e-12);
  EXPECT_NEAR(judged.vio_ape->max, 0.25, 1e-12);
  EXPECT_LT(judged.ape->max, 1e-12);
  EXPECT_FALSE(judged.map_frame_ape);
  EXPECT_FALSE(judged.relocalisation);
}

/// On paper: a map with places at x = 0, 4 and 8 m (that at 8 m can't be found), and a flight of
/// four keyframes at x = 0.5, 4.5, 8.5 and 20 m, later by a second, whose map frame is the truth
/// moved by 1 m along x. Those at 0.5 and 4.5 m see a place of the map again.
class JudgeMapTest : public ::testing::Test {
 protected:
  JudgeMapTest() {
    for (int i = 0; i < 3; ++i) {
      Add(&truth_.map, Pose(4.0 * i, i == 1 ? 1 : 0), 100 + i, true);
    }
    flight_.keyframes[2].is_place = false;
    const double x[] = {0.5, 4.5, 8.5, 20};
    for (int i = 0; i < 4; ++i) {
      Add(&truth_.own, Pose(x[i]), i, false);
    }
  }
  void Add(Trajectory* truth, const Rigid3& T_truth_B, double seconds, bool is_of_map) {
    truth->stamps_ns.push_back(Seconds(seconds));
    truth->poses.push_back(T_truth_B);
    FlownKeyframe keyframe;
    keyframe.stamp_ns = Seconds(seconds);
    keyframe.T_M_B = Pose(1) * T_truth_B;
    keyframe.T_W_B = T_truth_B;
    keyframe.is_of_map = is_of_map;
    flight_.keyframes.push_back(keyframe);
  }
  void AddLoop(int current, int old) {
    const auto pose = [&](int i) { return flight_.keyframes[static_cast<std::size_t>(i)].T_W_B; };
    flight_.loops.push_back({old, current, pose(old).Inverse() * pose(current), 0.5});
  }

  Flight flight_;
  FlightTruth truth_;
};

TEST_F(JudgeMapTest, CountsRevisitsOfTheMap) {
  AddLoop(3, 0);
  AddLoop(6, 0);  // right in its pose, but nothing that had to be found
  const JudgedFlight judged = JudgeFlight(flight_, truth_, kExtrinsic);
  EXPECT_EQ(judged.map_revisits, 2);
  EXPECT_EQ(judged.map_revisits_found, 1);
  // Of the loops' own score, which asks not whether a keyframe is a place: 3, 4 and 5.
  EXPECT_EQ(judged.score.revisits, 3);
  EXPECT_EQ(judged.score.correct, 2);
  // 1 of the 2 that see a place; the flight's own keyframes are 1 s apart, too young to be seen.
  EXPECT_DOUBLE_EQ(judged.recall_at_precision_1, 1.0 / 2);
}

TEST_F(JudgeMapTest, TakesCriteriaOfTheMap) {
  JudgeOptions options;
  options.map_criteria.revisit_distance_m = 0.6;  // keyframe 4 is hypot(0.5, 1) = 1.12 m away
  EXPECT_EQ(JudgeFlight(flight_, truth_, kExtrinsic, options).map_revisits, 1);
  options.map_criteria.revisit_distance_m = 100;
  EXPECT_EQ(JudgeFlight(flight_, truth_, kExtrinsic, options).map_revisits, 4);
}

TEST_F(JudgeMapTest, TellsHowFarOffPlacesAreFound) {
  AddLoop(3, 0);
  const JudgedFlight judged = JudgeFlight(flight_, truth_, kExtrinsic);
  ASSERT_TRUE(judged.relocalisation);
  const std::vector<RelocalisationBin>& bins = judged.relocalisation->by_distance;
  // Nearest places: 0.5 m (found), 1.12 m, hypot(4.5, 1) = 4.61 m; 16 m is beyond the bins.
  EXPECT_EQ(bins[1].keyframes, 1);
  EXPECT_EQ(bins[1].found, 1);
  EXPECT_EQ(bins[2].keyframes, 1);
  EXPECT_EQ(bins[2].found, 0);
  EXPECT_EQ(bins[9].keyframes, 1);
}

TEST_F(JudgeMapTest, MeasuresErrorsInTheFrameOfTheMap) {
  for (std::size_t i = 3; i < 7; ++i) {
    flight_.keyframes[i].T_M_B = Pose(0, 0.2) * flight_.keyframes[i].T_M_B;
  }
  const JudgedFlight judged = JudgeFlight(flight_, truth_, kExtrinsic);
  // The map's keyframes fit the truth exactly; the flight's are 0.2 m aside of it.
  EXPECT_NEAR(judged.map_frame_ape->max, 0.2, 1e-9);
  EXPECT_NEAR(judged.map_frame_ape->min, 0.2, 1e-9);
  EXPECT_LT(judged.ape->max, 1e-9);
}

TEST_F(JudgeMapTest, TakesAMapOfWhichOnlyStampsAreKnown) {
  for (std::size_t i = 0; i < 3; ++i) {
    flight_.keyframes[i].has_poses = false;
  }
  EXPECT_FALSE(JudgeFlight(flight_, truth_, kExtrinsic).map_frame_ape);
}

TEST_F(JudgeMapTest, SearchesTheFlightOnlyWhereItLeavesPlaces) {
  // Keyframe 6 comes back to keyframe 3 after 30 s.
  truth_.own.poses[3] = truth_.own.poses[0];
  truth_.own.stamps_ns[3] = flight_.keyframes[6].stamp_ns = Seconds(30);
  flight_.keyframes[0].is_place = false;
  flight_.detections = {{3, 6, 0.5}};
  EXPECT_TRUE(JudgeFlight(flight_, truth_, kExtrinsic).decisions[0]->is_revisit);
  for (std::size_t i = 3; i < 7; ++i) {
    flight_.keyframes[i].is_place = false;
  }
  EXPECT_FALSE(JudgeFlight(flight_, truth_, kExtrinsic).decisions[0]->is_revisit);
}

TEST(JudgeFlight, AcceptsAnEmptyFlight) {
  const JudgedFlight judged = JudgeFlight({}, {}, Rigid3());
  EXPECT_EQ(judged.score.accepted, 0);
  EXPECT_FALSE(judged.ape);
  EXPECT_TRUE(judged.detections.empty());
}

}  // namespace
}  // namespace deja_view
