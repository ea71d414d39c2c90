#include "deja_view/pose_graph/loop_consistency.hpp"

#include "deja_view/base/angles.hpp"

#include <numeric>
#include <vector>

#include "rounds.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using State = LoopConsistency::State;

using test::AddTrueLoops;
using test::kPerRound;
using test::MakeTwoWorlds;
using test::TrueLoop;
using test::Truth;
using test::WrongLoop;

/// Two rounds of perfect odometry; from `jump_at` on displaced by `jump`.
PoseGraph MakeGraph(const Rigid3& jump = {}, int jump_at = 2 * kPerRound) {
  PoseGraph graph{PoseGraphOptions{}};
  for (int i = 0; i < 2 * kPerRound; ++i) {
    graph.AddNode(0, i < jump_at ? Truth(i) : jump * Truth(i));
  }
  return graph;
}

TEST(LoopConsistency, ASingleLoopWaits) {
  PoseGraph graph = MakeGraph();
  LoopConsistency consistency({});
  const auto decision = consistency.Add(TrueLoop(3, 3 + kPerRound), 3, graph);
  EXPECT_TRUE(decision.believed.empty());
  EXPECT_EQ(decision.state, State::kPending);
}

TEST(LoopConsistency, AgreeingLoopsAreAcceptedWithThoseThatWaited) {
  PoseGraph graph = MakeGraph();
  LoopConsistency consistency({});
  EXPECT_TRUE(AddTrueLoops({3, 5}, &consistency, &graph).empty());
  EXPECT_EQ(AddTrueLoops({7}, &consistency, &graph), std::vector<int>({3, 5, 7}));
  EXPECT_EQ(AddTrueLoops({9}, &consistency, &graph), std::vector<int>({9}));
}

TEST(LoopConsistency, AWithdrawnLoopVotesNoMore) {
  PoseGraph graph = MakeGraph();
  LoopConsistency consistency({});
  EXPECT_TRUE(AddTrueLoops({3, 5}, &consistency, &graph).empty());
  consistency.Withdraw(5, 5, 5 + kPerRound, graph);
  EXPECT_TRUE(AddTrueLoops({7}, &consistency, &graph).empty());
  EXPECT_EQ(AddTrueLoops({9}, &consistency, &graph), std::vector<int>({3, 7, 9}));
}

TEST(LoopConsistency, WithoutMinSupportEveryPlausibleLoopIsBelieved) {
  PoseGraph graph = MakeGraph();
  LoopConsistencyOptions options;
  options.min_support = 0;
  LoopConsistency consistency(options);
  EXPECT_EQ(AddTrueLoops({3}, &consistency, &graph), std::vector<int>({3}));
}

TEST(LoopConsistency, RefusesLoopsThatContradictAcceptedOnes) {
  PoseGraph graph = MakeGraph();
  LoopConsistencyOptions options;
  options.plausible_soon_over_depth = options.plausible_over_depth = 20;
  LoopConsistency consistency(options);
  ASSERT_EQ(AddTrueLoops({3, 5, 7, 9}, &consistency, &graph).size(), 4U);
  const Rigid3 error{Eigen::Quaterniond::Identity(), {1.5, 0.4, 0}};
  for (const int i : {4, 6, 8, 10}) {
    const auto decision = consistency.Add(WrongLoop(i, i + kPerRound, error), 100 + i, graph);
    EXPECT_TRUE(decision.believed.empty());
    EXPECT_EQ(decision.state, State::kPending);
  }
  EXPECT_EQ(AddTrueLoops({11}, &consistency, &graph), std::vector<int>({11}));
}

TEST(LoopConsistency, ALoopThatFitsNothingIsRefusedAndHoldsUpNothing) {
  PoseGraph graph = MakeGraph();
  LoopConsistency consistency({});
  const Rigid3 error{Eigen::Quaterniond::Identity(), {0, 0.5, 0}};
  EXPECT_TRUE(consistency.Add(WrongLoop(2, 2 + kPerRound, error), 100, graph).believed.empty());
  EXPECT_EQ(AddTrueLoops({3, 5, 7}, &consistency, &graph), std::vector<int>({3, 5, 7}));
}

/// An odometry that jumped by `jump` between the two rounds, as loops that all agree claim.
State StateAfterLoops(const Rigid3& jump, int count) {
  PoseGraph graph = MakeGraph(jump, 30);
  LoopConsistencyOptions options;
  LoopConsistency consistency(options);
  State state = State::kPending;
  for (int i = 0; i < count; ++i) {
    state = consistency.Add(TrueLoop(i, i + kPerRound), i, graph).state;
  }
  return state;
}

TEST(LoopConsistency, ImplausibleDriftStaysOutHoweverManyLoopsClaimIt) {
  const Rigid3 small{Eigen::Quaterniond::Identity(), {0, 0.3, 0}};
  const Rigid3 far{Eigen::Quaterniond::Identity(), {0, 2.5, 0}};
  EXPECT_EQ(StateAfterLoops(small, 3), State::kAccepted);
  EXPECT_EQ(StateAfterLoops(far, 3), State::kImplausible);
  EXPECT_EQ(StateAfterLoops(far, 30), State::kImplausible);
}

/// So uncertain that it agrees with all, and 0.7 m off where 5 m are seen.
TEST(LoopConsistency, RightAfterAnotherALoopMayClaimLessDrift) {
  for (const int steps : {2, 17}) {  // 0.6 m and 5.3 m later
    PoseGraph graph = MakeGraph();
    LoopConsistency consistency({});
    ASSERT_EQ(AddTrueLoops({3, 5, 7}, &consistency, &graph).size(), 3U);
    const Rigid3 error{Eigen::Quaterniond::Identity(), {0, 0.7, 0}};
    PoseGraphLoop loop = WrongLoop(7 + steps, 7 + steps + kPerRound, error);
    loop.covariance *= 1e4;
    EXPECT_EQ(consistency.Add(loop, 100, graph).state,
              steps < 5 ? State::kImplausible : State::kAccepted);
  }
}

std::vector<int> Range(int first, int end) {
  std::vector<int> range(static_cast<std::size_t>(end - first));
  std::iota(range.begin(), range.end(), first);
  return range;
}

/// 0.3 m off where 5 m are seen: 2.8 standard deviations per degree of freedom, and few enough that
/// it agrees with the others.
PoseGraphLoop SurprisingLoop(int i) {
  PoseGraphLoop loop = WrongLoop(i, i + kPerRound, {Eigen::Quaterniond::Identity(), {0, 0.3, 0}});
  loop.covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * 0.05 * 0.05;
  return loop;
}

TEST(LoopConsistency, ALoopThatSurprisesMoreThanOthersDidMayClaimLess) {
  const auto state = [](int loops_before, int steps) {
    PoseGraph graph = MakeGraph();
    LoopConsistency consistency({});
    AddTrueLoops(Range(0, loops_before), &consistency, &graph);
    return consistency.Add(SurprisingLoop(loops_before - 1 + steps), 100, graph).state;
  };
  EXPECT_EQ(state(20, 1), State::kImplausible);
  EXPECT_EQ(state(3, 1), State::kAccepted) << "nothing is usual yet";
  EXPECT_EQ(state(20, 17), State::kAccepted) << "the odometry may have drifted in 5.3 m";
}

TEST(LoopConsistency, DriftAfterALongWayMakesNoSurpriseUsual) {
  const Rigid3 jump{Eigen::Quaterniond::Identity(), {0, 0.3, 0}};
  PoseGraph graph = MakeGraph(jump, 61);
  LoopConsistency consistency({});
  AddTrueLoops(Range(0, 20), &consistency, &graph);
  ASSERT_EQ(AddTrueLoops({37, 38, 39}, &consistency, &graph), std::vector<int>({37, 38, 39}));
  EXPECT_EQ(consistency.Add(SurprisingLoop(20), 100, graph).state, State::kImplausible);
}

TEST(LoopConsistency, ALoopDoesNotBecomePlausibleByWaiting) {
  PoseGraph graph = MakeGraph();
  LoopConsistency consistency({});
  ASSERT_EQ(AddTrueLoops({3, 5, 7}, &consistency, &graph).size(), 3U);
  PoseGraphLoop loop = WrongLoop(8, 8 + kPerRound, {Eigen::Quaterniond::Identity(), {0, 0.7, 0}});
  loop.covariance *= 1e4;  // it agrees with all
  ASSERT_EQ(consistency.Add(loop, 100, graph).state, State::kImplausible);
  EXPECT_EQ(AddTrueLoops(Range(30, 38), &consistency, &graph), Range(30, 38));
}

TEST(LoopConsistency, LoopsThatHaveNotMovedTheTrajectoryYetDontHoldIt) {
  const Rigid3 jump{Eigen::Quaterniond::Identity(), {0, 0.9, 0}};
  EXPECT_EQ(StateAfterLoops(jump, 3), State::kAccepted);
  EXPECT_EQ(StateAfterLoops(jump, 4), State::kAccepted);
}

TEST(LoopConsistency, ImplausibleYawStaysOutHoweverManyLoopsClaimIt) {
  // Turned about the drone, so that nearly nothing but yaw is wrong.
  const auto turn = [](double degrees) {
    const Rigid3 T{FromYaw(degrees * kDegree), Eigen::Vector3d::Zero()};
    return Rigid3{T.q, Truth(41).t - T.q * Truth(41).t};
  };
  EXPECT_EQ(StateAfterLoops(turn(3), 3), State::kAccepted);
  EXPECT_EQ(StateAfterLoops(turn(12), 3), State::kImplausible);
  EXPECT_EQ(StateAfterLoops(turn(12), 30), State::kImplausible);
}

TEST(LoopConsistency, AMapsKeyframesAreAsFarApartAsItSays) {
  LoopConsistencyOptions options;
  options.max_path_over_depth = 1;
  const LoopConsistency consistency(options);
  // 25 poses, 7.9 m of path, yet 3.7 m apart.
  const auto compare = [&](const PoseGraph& graph) {
    return consistency.Compare(TrueLoop(5, 45), TrueLoop(30, 50), graph);
  };
  EXPECT_FALSE(compare(MakeTwoWorlds(false)).is_comparable);
  EXPECT_TRUE(compare(MakeTwoWorlds(true)).agrees);
}

TEST(LoopConsistency, LoopsOfOneKeyframeDoNotSupportEachOther) {
  PoseGraph graph = MakeGraph();
  LoopConsistency consistency({});
  for (const int from : {3, 4, 5, 6}) {
    EXPECT_TRUE(consistency.Add(TrueLoop(from, 45), from, graph).believed.empty());
  }
  EXPECT_EQ(consistency.Add(TrueLoop(5, 46), 10, graph).believed.size(), 1U);
}

TEST(LoopConsistency, ComparesOnlyOverShortOdometryOfTheSameSequences) {
  PoseGraph graph{PoseGraphOptions{}};
  for (int i = 0; i < 200; ++i) {
    graph.AddNode(i / 100, Truth(i));
  }
  LoopConsistencyOptions options;
  options.max_path_over_depth = 1;
  const LoopConsistency consistency(options);
  const auto compare = [&](int from_a, int to_a, int from_b, int to_b) {
    return consistency.Compare(TrueLoop(from_a, to_a), TrueLoop(from_b, to_b), graph);
  };
  EXPECT_TRUE(compare(5, 45, 10, 50).is_comparable);
  EXPECT_TRUE(compare(5, 45, 10, 50).agrees);
  EXPECT_FALSE(compare(5, 45, 25, 50).is_comparable) << "20 poses, 6.3 m, on the old side";
  EXPECT_FALSE(compare(5, 45, 10, 65).is_comparable);
  EXPECT_FALSE(compare(5, 45, 10, 130).is_comparable) << "another sequence";
  EXPECT_FALSE(compare(5, 145, 110, 150).is_comparable);
  const Rigid3 yawed{FromYaw(0.1), Eigen::Vector3d::Zero()};
  const auto turned = consistency.Compare(TrueLoop(5, 45), WrongLoop(10, 50, yawed), graph);
  EXPECT_TRUE(turned.is_comparable);
  EXPECT_FALSE(turned.agrees);
}

TEST(LoopConsistency, ForgetsWhatIsOlderThanItsWindow) {
  PoseGraph graph = MakeGraph();
  LoopConsistencyOptions options;
  options.window = 2;
  LoopConsistency consistency(options);
  EXPECT_TRUE(AddTrueLoops({3, 5, 7, 9}, &consistency, &graph).empty());
}

TEST(LoopConsistencyOptions, ListsAllViolations) {
  EXPECT_TRUE(LoopConsistencyOptions{}.Validate().empty());
  LoopConsistencyOptions options;
  options.min_support = -1;
  options.min_support_join = -1;
  options.max_support_ratio = -1;
  options.window = 0;
  options.max_path_over_depth = 0;
  options.max_sigmas = 0;
  options.plausible_soon_over_depth = 0;
  options.plausible_over_depth = 0;
  options.plausible_m_per_m = -1;
  options.surprising_over_depth = 0;
  options.max_innovation_ratio = 0;
  options.plausible_yaw_deg = 0;
  options.plausible_yaw_deg_per_m = -1;
  options.min_span_over_depth = -1;
  options.same_place_over_depth = -1;
  options.max_rival_ratio = -1;
  options.span_window = 0;
  const auto errors = options.Validate();
  ASSERT_EQ(errors.size(), 17U);
  EXPECT_EQ(errors.front(), "min_support: -1, expected at least 0");
  EXPECT_EQ(errors.back(), "plausible_yaw_deg_per_m: -1, expected at least 0");
}

}  // namespace
}  // namespace deja_view
