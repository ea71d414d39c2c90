#include "deja_view/pose_graph/loop_consistency.hpp"

#include "deja_view/base/angles.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

using State = LoopConsistency::State;

constexpr int kPerRound = 40;

/// Pose `i` of a circle of 2 m radius: 0.31 m of path per pose.
Rigid3 Truth(int i) {
  const double angle = 2.0 * 3.14159265358979323846 * i / kPerRound;
  return {FromYaw(angle) * ExpSo3({0.1, 0.05, 0}),
          {2 * std::cos(angle), 2 * std::sin(angle), 1 + 0.1 * std::sin(3 * angle)}};
}

/// Two rounds of perfect odometry; from `jump_at` on displaced by `jump`.
PoseGraph MakeGraph(const Rigid3& jump = {}, int jump_at = 2 * kPerRound) {
  PoseGraph graph{PoseGraphOptions{}};
  for (int i = 0; i < 2 * kPerRound; ++i) {
    graph.AddNode(0, i < jump_at ? Truth(i) : jump * Truth(i));
  }
  return graph;
}

PoseGraphLoop TrueLoop(int from, int to) {
  PoseGraphLoop loop;
  loop.from = from;
  loop.to = to;
  loop.T_from_to = Truth(from).Inverse() * Truth(to);
  loop.covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-5;
  return loop;
}

/// All wrong loops with the same `error` (in the world) agree with each other.
PoseGraphLoop WrongLoop(int from, int to, const Rigid3& error) {
  PoseGraphLoop loop = TrueLoop(from, to);
  loop.T_from_to = Truth(from).Inverse() * error * Truth(to);
  return loop;
}

/// Adds loops from i to i + 40 for each i, accepted ones to the graph too; returns the accepted
/// tags.
std::vector<int> AddTrueLoops(const std::vector<int>& from,
                              LoopConsistency* consistency,
                              PoseGraph* graph) {
  std::vector<int> tags;
  for (const int i : from) {
    for (const auto& entry : consistency->Add(TrueLoop(i, i + kPerRound), i, *graph).believed) {
      EXPECT_EQ(entry.state, State::kAccepted);
      graph->AddLoop(entry.loop);
      tags.push_back(entry.tag);
    }
  }
  return tags;
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
  consistency.Withdraw(5);
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
  options.plausible_over_depth = 20;
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

/// Two worlds of one round each.
PoseGraph MakeTwoWorlds(bool is_map = false) {
  PoseGraph graph{PoseGraphOptions{}};
  const Rigid3 other_world{FromYaw(2), {50, 20, 5}};
  for (int i = 0; i < 2 * kPerRound; ++i) {
    const bool is_first = i < kPerRound;
    graph.AddNode(i / kPerRound, is_first ? Truth(i) : other_world * Truth(i), is_map && is_first);
  }
  return graph;
}

TEST(LoopConsistency, JoiningTwoWorldsNeedsMoreSupport) {
  PoseGraph graph = MakeTwoWorlds();
  LoopConsistencyOptions options;
  options.min_span_over_depth = 0.4;
  LoopConsistency consistency(options);
  EXPECT_TRUE(AddTrueLoops({3, 5, 7, 9}, &consistency, &graph).empty());
  EXPECT_EQ(AddTrueLoops({11}, &consistency, &graph), std::vector<int>({3, 5, 7, 9, 11}));
  EXPECT_TRUE(graph.AreJoined(0, 1));
}

/// Within less than the scene's depth, 5 m, a copy of what is seen stays in view.
TEST(LoopConsistency, LoopsThatJoinMustSpread) {
  PoseGraph graph = MakeTwoWorlds();
  LoopConsistency consistency{LoopConsistencyOptions{}};
  EXPECT_TRUE(AddTrueLoops({3, 5, 7, 9, 11, 13, 15, 17}, &consistency, &graph).empty());  // 4.4 m
  EXPECT_EQ(AddTrueLoops({20}, &consistency, &graph).size(), 9U);                         // 5.3 m
}

TEST(LoopConsistency, LoopsThatJoinMustHaveFewRivals) {
  const Rigid3 shift{Eigen::Quaterniond::Identity(), {0, 3, 0}};
  for (const int rivals : {3, 4}) {
    PoseGraph graph = MakeTwoWorlds();
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0.4;
    LoopConsistency consistency(options);
    for (int i = 0; i < rivals; ++i) {
      EXPECT_TRUE(
          consistency.Add(WrongLoop(i, i + kPerRound, shift), 100 + i, graph).believed.empty());
    }
    // The seventh of these has six that agree.
    EXPECT_EQ(AddTrueLoops({4, 5, 7, 9, 11, 13, 15}, &consistency, &graph).empty(), rivals > 3);
  }
}

TEST(LoopConsistency, ImpreciseLoopsAreNoRivals) {
  // Of 5 m of depth: 0.5 m are within 0.15 of it, 1 m is not; 8 and 12 degrees alike.
  const auto turn = [](double degrees) {
    const Rigid3 T{FromYaw(degrees * kDegree), {0, 0, 0}};
    return Rigid3{T.q, Truth(2).t - T.q * Truth(2).t};  // about one of the places
  };
  const auto joins = [](const Rigid3& error) {
    PoseGraph graph = MakeTwoWorlds();
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0.4;
    LoopConsistency consistency(options);
    for (int i = 0; i < 6; ++i) {
      consistency.Add(WrongLoop(i, i + kPerRound, error), 100 + i, graph);
    }
    return !AddTrueLoops({4, 5, 7, 9, 11, 13, 15}, &consistency, &graph).empty();
  };
  EXPECT_TRUE(joins({Eigen::Quaterniond::Identity(), {0, 0.5, 0}}));
  EXPECT_FALSE(joins({Eigen::Quaterniond::Identity(), {0, 1.0, 0}}));
  EXPECT_TRUE(joins(turn(8)));
  EXPECT_FALSE(joins(turn(12)));
}

/// A loop so uncertain that it agrees with all must not bring in a wrong one.
TEST(LoopConsistency, LoopsThatJoinMustAgreeAmongThemselves) {
  for (const bool is_wrong : {false, true}) {
    PoseGraph graph = MakeTwoWorlds();
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0.64;  // 3.2 m: the uncertain loop reaches it
    LoopConsistency consistency(options);
    const Rigid3 error{Eigen::Quaterniond::Identity(), {is_wrong ? 0.6 : 0.0, 0, 0}};
    EXPECT_TRUE(consistency.Add(WrongLoop(3, 3 + kPerRound, error), 100, graph).believed.empty());
    EXPECT_TRUE(AddTrueLoops({4, 5, 7, 9, 11, 13}, &consistency, &graph).empty());
    PoseGraphLoop uncertain = TrueLoop(15, 15 + kPerRound);
    uncertain.covariance *= 1e4;
    std::vector<int> tags;
    for (const auto& entry : consistency.Add(uncertain, 200, graph).believed) {
      tags.push_back(entry.tag);
    }
    const std::vector<int> right = {4, 5, 7, 9, 11, 13, 200};
    std::vector<int> all = right;
    all.insert(all.begin(), 100);
    EXPECT_EQ(tags, is_wrong ? right : all);
  }
}

/// The drone hovers: twelve loops between the same two places say it once.
TEST(LoopConsistency, LoopsOfTheSameTwoPlacesAreOneWitness) {
  for (const double step_m : {0.02, 0.5}) {
    PoseGraph graph{PoseGraphOptions{}};
    const auto pose = [&](int i) {
      return Rigid3{FromYaw(0), {0.5 * (i / 13) + step_m * (i % 13), 0, 0}};
    };
    for (int i = 0; i < 26; ++i) {
      graph.AddNode(0, pose(i));
    }
    for (int i = 0; i < 26; ++i) {
      graph.AddNode(1, pose(i));
    }
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0;
    LoopConsistency consistency(options);
    std::size_t believed = 0;
    for (int i = 0; i < 6; ++i) {
      PoseGraphLoop loop = TrueLoop(0, 1);
      loop.from = i;
      loop.to = 26 + i;
      loop.T_from_to = Rigid3::Identity();
      loop.scene_depth = 10;  // 0.2 m are the same place
      believed += consistency.Add(loop, i, graph).believed.size();
    }
    EXPECT_EQ(believed > 0, step_m > 0.1) << step_m;
  }
}

/// A drone that stands still joins a map that saw what it sees from enough places.
TEST(LoopConsistency, ADroneThatStandsJoinsByTheMapsPlaces) {
  // Loops of six keyframes `move_m` apart with `places` of the map, `step` poses apart.
  const auto joins = [](int places, int step, bool is_map, double move_m = 0) {
    PoseGraph graph = MakeTwoWorlds(is_map);
    const Rigid3 T_W_B = graph.node(kPerRound + 10).T_W_B;
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0.3;  // 1.5 m
    LoopConsistency consistency(options);
    for (int i = 0; i < 6; ++i) {
      const Rigid3 moved{Eigen::Quaterniond::Identity(), {0, 0, i * move_m}};
      const int standing = graph.AddNode(1, T_W_B * moved);
      for (int k = 0; k < places; ++k) {
        PoseGraphLoop loop = TrueLoop(step * k, kPerRound + 10);
        loop.T_from_to = Truth(step * k).Inverse() * Truth(10) * moved;
        loop.to = standing;
        if (!consistency.Add(loop, i, graph).believed.empty()) {
          return true;
        }
      }
    }
    return false;
  };
  EXPECT_TRUE(joins(4, 3, true));
  EXPECT_FALSE(joins(4, 3, false));  // the flight's own, which drift
  EXPECT_FALSE(joins(3, 3, true));
  EXPECT_TRUE(joins(4, 3, true, 0.15));
  EXPECT_FALSE(joins(3, 3, true, 0.15));  // 18 witnesses within 0.75 m, but of three places
  EXPECT_FALSE(joins(4, 1, true));        // within 0.9 m of 5 m of depth
}

/// What is a long way for a small room is none in a hall.
TEST(LoopConsistency, SpansAreMeasuredByTheScenesDepth) {
  for (const double depth : {2.0, 5.0}) {
    PoseGraph graph = MakeTwoWorlds();
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0.6;
    LoopConsistency consistency(options);
    std::size_t believed = 0;
    for (const int i : {3, 4, 5, 6, 7, 8, 9}) {  // 1.9 m
      PoseGraphLoop loop = TrueLoop(i, i + kPerRound);
      loop.scene_depth = depth;
      believed += consistency.Add(loop, i, graph).believed.size();
    }
    EXPECT_EQ(believed, depth < 3 ? 7U : 0U);
  }
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
  options.plausible_over_depth = 0;
  options.plausible_m_per_m = -1;
  options.plausible_yaw_deg = 0;
  options.plausible_yaw_deg_per_m = -1;
  options.min_span_over_depth = -1;
  options.same_place_over_depth = -1;
  options.max_rival_ratio = -1;
  options.span_window = 0;
  const auto errors = options.Validate();
  ASSERT_EQ(errors.size(), 14U);
  EXPECT_EQ(errors.front(), "min_support: -1, expected at least 0");
  EXPECT_EQ(errors.back(), "plausible_yaw_deg_per_m: -1, expected at least 0");
}

}  // namespace
}  // namespace deja_view
