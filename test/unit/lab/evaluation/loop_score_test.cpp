#include "deja_view/lab/evaluation/loop_score.hpp"

#include "deja_view/base/angles.hpp"

#include "looks_ahead.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

TrueKeyframe At(double seconds, double x, double yaw) {
  return {static_cast<std::int64_t>(seconds * 1e9), Rigid3{FromYaw(yaw), {x, 0, 0}}, false};
}

TEST(ScoreLoops, CountsRevisitsByAgeDistanceAndAngle) {
  const std::vector<TrueKeyframe> keyframes = {
      At(0, 0, 0),
      At(5, 0, 0),      // too soon
      At(11, 0.5, 0),   // revisits 0
      At(12, 5, 0),     // too far
      At(20, 0, 1.5),   // looks elsewhere
      At(30, 1.9, 0.5)  // revisits 0, 5 and 11
  };
  const LoopScore score = ScoreLoops(keyframes, {}, kLooksAhead);
  EXPECT_EQ(score.revisits, 2);
  EXPECT_EQ(score.revisits_found, 0);
  EXPECT_EQ(score.recall(), 0.0);
  EXPECT_EQ(score.precision(), 1.0);
}

TEST(ScoreLoops, JudgesLoopsByTheirRelativePose) {
  const std::vector<TrueKeyframe> keyframes = {At(0, 0, 0), At(20, 1, 0.3), At(21, 1, 0.3)};
  const Rigid3 truth = keyframes[0].T_truth_B->Inverse() * *keyframes[1].T_truth_B;
  const Rigid3 shifted{truth.q, truth.t + Eigen::Vector3d(0.51, 0, 0)};
  const Rigid3 turned{truth.q * FromYaw(0.18), truth.t};
  const Rigid3 nearly{truth.q * FromYaw(0.17), truth.t + Eigen::Vector3d(0, 0.2, 0)};
  const LoopScore score =
      ScoreLoops(keyframes, {{0, 1, shifted}, {0, 1, turned}, {0, 2, nearly}}, kLooksAhead);
  EXPECT_EQ(score.accepted, 3);
  EXPECT_EQ(score.correct, 1);
  EXPECT_EQ(score.is_correct, (std::vector<bool>{false, false, true}));
  EXPECT_EQ(score.revisits, 2);
  EXPECT_EQ(score.revisits_found, 1);
  EXPECT_NEAR(score.worst.distance_m, 0.51, 1e-9);
  EXPECT_NEAR(score.worst.angle_deg, ToDegrees(0.18), 1e-9);
}

TEST(ScoreLoops, LeavesOutWhatTheTruthDoesNotCover) {
  std::vector<TrueKeyframe> keyframes = {At(0, 0, 0), At(20, 0, 0)};
  keyframes[1].T_truth_B.reset();
  const LoopScore score = ScoreLoops(keyframes, {{0, 1, {}}}, kLooksAhead);
  EXPECT_EQ(score.accepted, 1);
  EXPECT_EQ(score.judged, 0);
  EXPECT_EQ(score.worst.distance_m, 0);
  EXPECT_EQ(score.revisits, 0);
}

TEST(ScoreLoops, ALoadedMapIsOldWhateverItsStamps) {
  std::vector<TrueKeyframe> keyframes = {At(100, 0, 0), At(20, 0, 0)};
  keyframes[0].is_old_only = true;
  const LoopScore score = ScoreLoops(keyframes, {{0, 1, {}}}, kLooksAhead);
  EXPECT_EQ(score.revisits, 1);
  EXPECT_EQ(score.revisits_found, 1);
  EXPECT_EQ(score.recall(), 1.0);
}

}  // namespace
}  // namespace deja_view
