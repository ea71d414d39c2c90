#include "deja_view/base/angles.hpp"
#include "deja_view/pose_graph/loop_consistency.hpp"

#include <vector>

#include "rounds.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::AddTrueLoops;
using test::kPerRound;
using test::MakeTwoWorlds;
using test::TrueLoop;
using test::Truth;
using test::WrongLoop;

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

/// The flights of one map support each other, those that nothing joins don't.
TEST(LoopConsistency, AMapOfTwoFlightsIsOne) {
  for (const bool are_joined : {false, true}) {
    const PoseGraph rounds = MakeTwoWorlds();
    std::vector<PoseGraph::Part> parts;
    for (int i = 0; i < 2 * kPerRound; ++i) {
      PoseGraphNode node = rounds.node(i);
      node.is_fixed = true;
      node.t_M_B = Truth(i).t;
      node.psi = i < kPerRound ? 0 : -2;
      parts.push_back({node, true});
    }
    std::vector<PoseGraphLoop> joints;
    if (are_joined) {
      joints.push_back(TrueLoop(3, 3 + kPerRound));
    }
    PoseGraph graph = PoseGraph::FromParts(PoseGraphOptions{}, parts, joints);
    EXPECT_EQ(graph.AreJoinedInMap(0, 1), are_joined);
    for (int i = 0; i < kPerRound; ++i) {
      graph.AddNode(2, Truth(i));
    }
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0.4;
    LoopConsistency consistency(options);
    std::size_t believed = 0;
    for (int i = 0; i < 8; ++i) {  // four of each
      const int flown = 2 * kPerRound + 2 * i;
      const PoseGraphLoop loop = TrueLoop(2 * i + (i % 2) * kPerRound, flown);
      believed += consistency.Add(loop, i, graph).believed.size();
    }
    EXPECT_EQ(believed, are_joined ? 8U : 0U);
  }
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

/// The first loops that join worlds saw copies; those of the truth show more places.
TEST(LoopConsistency, AJoinFallsWhenLoopsThatContradictItShowMorePlaces) {
  PoseGraph graph = MakeTwoWorlds();
  LoopConsistencyOptions options;
  options.min_span_over_depth = 0.4;
  LoopConsistency consistency(options);
  const Rigid3 shift{Eigen::Quaterniond::Identity(), {0, 3, 0}};
  for (int i = 0; i < 6; ++i) {  // of six places
    const auto decision =
        consistency.Add(WrongLoop(2 * i, 2 * i + kPerRound, shift), 100 + i, graph);
    for (const auto& entry : decision.believed) {
      graph.AddLoop(entry.loop);
    }
  }
  ASSERT_TRUE(graph.AreJoined(0, 1));
  EXPECT_TRUE(AddTrueLoops({14, 14, 16, 18, 20, 22, 24}, &consistency, &graph).empty()) << "of six";
  const auto decision = consistency.Add(TrueLoop(26, 26 + kPerRound), 26, graph);
  EXPECT_TRUE(decision.contradicts_join);
  EXPECT_TRUE(decision.believed.empty());

  graph.Separate(1);
  consistency.Separate(1, graph);
  const auto again = consistency.Reconsider(graph);
  EXPECT_EQ(again.state, LoopConsistency::State::kAccepted);
  EXPECT_EQ(again.believed.size(), 8U);
  for (const auto& entry : again.believed) {
    EXPECT_LT(entry.tag, 100);
    graph.AddLoop(entry.loop);
  }
  EXPECT_LT(
      (graph.Correction(kPerRound + 5) * graph.node(kPerRound + 5).T_W_B.t - Truth(5).t).norm(),
      1e-6);
}

/// The same copies later, where the worlds are joined rightly.
TEST(LoopConsistency, CopiesOfFewerPlacesDontUndoAJoin) {
  for (const int places : {7, 8, 9}) {
    PoseGraph graph = MakeTwoWorlds();
    LoopConsistencyOptions options;
    options.min_span_over_depth = 0.4;
    LoopConsistency consistency(options);
    ASSERT_EQ(AddTrueLoops({0, 1, 2, 3, 4, 5, 6, 7}, &consistency, &graph).size(), 8U);
    const Rigid3 shift{Eigen::Quaterniond::Identity(), {0, 3, 0}};
    bool falls = false;
    for (int i = 0; i < 20; ++i) {
      const int from = 10 + i % places;
      falls = falls || consistency.Add(WrongLoop(from, 10 + i + kPerRound, shift), 100 + i, graph)
                           .contradicts_join;
    }
    EXPECT_EQ(falls, places > 8) << places;
  }
}

}  // namespace
}  // namespace deja_view
