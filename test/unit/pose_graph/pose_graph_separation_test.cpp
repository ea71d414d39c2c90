#include "deja_view/base/angles.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <set>
#include <vector>

#include "rounds.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::kPerRound;
using test::MakeTwoWorlds;
using test::TrueLoop;
using test::WrongLoop;
using testing::ElementsAre;
using testing::IsEmpty;

const Rigid3 kWrong{FromYaw(0.3), {0, 3, 0}};

/// Joins the second world by wrong loops from every fourth node on.
void JoinWrongly(PoseGraph* graph) {
  for (int i = 0; i < kPerRound; i += 4) {
    graph->AddLoop(WrongLoop(i, i + kPerRound, kWrong));
  }
  graph->Solve();
}

/// The nodes of a sequence are where its odometry has them, seen from its first one.
void ExpectAsFlown(const PoseGraph& graph, int first, double within_m) {
  for (int i = first; i < first + kPerRound; ++i) {
    const Rigid3 flown = graph.node(first).T_W_B.Inverse() * graph.node(i).T_W_B;
    const Rigid3 now = graph.node(first).T_M_B().Inverse() * graph.node(i).T_M_B();
    EXPECT_LT((now.t - flown.t).norm(), within_m) << i;
  }
}

/// Ties lead from the first node of a sequence to all of its that are live.
void ExpectAllTied(const PoseGraph& graph, int first) {
  std::set<int> tied = {first};
  for (std::size_t before = 0; before != tied.size();) {
    before = tied.size();
    for (const auto& [ends, tie] : graph.ties()) {
      if (tied.count(ends.first) + tied.count(ends.second) == 1) {
        tied.insert({ends.first, ends.second});
      }
    }
  }
  for (int i = first; i < first + kPerRound; ++i) {
    EXPECT_TRUE(!graph.IsLive(i) || tied.count(i) > 0) << i;
  }
}

TEST(PoseGraphSeparation, ASequenceGoesBackToItsOwnWorld) {
  for (const bool is_map : {false, true}) {
    PoseGraph graph = MakeTwoWorlds(is_map);
    JoinWrongly(&graph);
    const int own = graph.AddLoop(TrueLoop(kPerRound + 2, kPerRound + 20));
    ASSERT_TRUE(graph.AreJoined(0, 1));
    ASSERT_GT(graph.Correction(kPerRound).t.norm(), 1.0);
    EXPECT_THAT(graph.Separate(1), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
    EXPECT_FALSE(graph.AreJoined(0, 1));
    EXPECT_FALSE(graph.IsAnchored(1));
    ASSERT_EQ(graph.loops().size(), 1U);
    EXPECT_EQ(graph.loops().begin()->first, own);
    EXPECT_LT(graph.Correction(kPerRound).t.norm(), 1e-9);
    ExpectAsFlown(graph, 0, 1e-6);
    ExpectAsFlown(graph, kPerRound, 1e-6);
    for (const auto& [ends, tie] : graph.ties()) {
      EXPECT_EQ(ends.first < kPerRound, ends.second < kPerRound);
    }

    graph.AddLoop(TrueLoop(3, 3 + kPerRound));
    graph.Solve();
    EXPECT_TRUE(graph.AreJoined(0, 1));
    for (int i = 0; i < kPerRound; ++i) {
      EXPECT_LT((graph.node(i + kPerRound).t_M_B - graph.node(i).t_M_B).norm(), 1e-6) << i;
    }
  }
}

/// A flight that keeps no places of its own hangs on the map's.
TEST(PoseGraphSeparation, DroppedNodesComeAlong) {
  PoseGraphOptions options;
  options.window = 8;
  const PoseGraph rounds = MakeTwoWorlds();
  PoseGraph graph(options);
  std::vector<int> withdrawn;
  for (int i = 0; i < 2 * kPerRound; ++i) {
    graph.AddNode(i / kPerRound, rounds.node(i).T_W_B, i < kPerRound);
    if (i < kPerRound) {
      graph.Keep(i);
      continue;
    }
    if (i % 2 == 0) {
      graph.AddLoop(WrongLoop(i - kPerRound, i, kWrong));
    }
    if (i % 10 == 9) {
      graph.Solve();
      const PoseGraph::Settled settled = graph.Reduce();
      withdrawn.insert(withdrawn.end(), settled.withdrawn.begin(), settled.withdrawn.end());
    }
  }
  ASSERT_THAT(withdrawn, IsEmpty());
  ASSERT_FALSE(graph.IsLive(kPerRound + 10));
  const std::size_t left = graph.loops().size();
  EXPECT_LT(left, 10U) << "most loops are in the ties by now";
  EXPECT_EQ(graph.Separate(1).size(), left);
  EXPECT_FALSE(graph.AreJoined(0, 1));
  ExpectAllTied(graph, kPerRound);
  ExpectAsFlown(graph, kPerRound, 0.01);
  EXPECT_LT(graph.Correction(kPerRound).t.norm(), 1e-9);

  graph.AddLoop(TrueLoop(38, 38 + kPerRound));
  graph.Solve();
  for (int i = 0; i < kPerRound; ++i) {
    EXPECT_LT((graph.node(i + kPerRound).t_M_B - graph.node(i).t_M_B).norm(), 0.02) << i;
  }
}

TEST(PoseGraphSeparation, WhatOnlyItJoinedComesApart) {
  PoseGraph graph = MakeTwoWorlds();
  const Rigid3 third_world{FromYaw(-1), {-20, 5, 0}};
  for (int i = 0; i < kPerRound; ++i) {
    graph.AddNode(2, third_world * test::Truth(i));
  }
  graph.AddLoop(TrueLoop(3, 2 * kPerRound + 3));
  graph.AddLoop(TrueLoop(kPerRound + 5, 2 * kPerRound + 5));
  ASSERT_TRUE(graph.AreJoined(0, 1));
  EXPECT_EQ(graph.Separate(2).size(), 2U);
  for (int sequence = 0; sequence < 3; ++sequence) {
    EXPECT_FALSE(graph.AreJoined(sequence, (sequence + 1) % 3)) << sequence;
    EXPECT_LT(graph.Correction(sequence * kPerRound).t.norm(), 1e-9) << sequence;
  }
}

TEST(PoseGraphSeparation, AMapsSequencesStayJoined) {
  const PoseGraph rounds = MakeTwoWorlds();
  std::vector<PoseGraph::Part> parts;
  for (int i = 0; i < 2 * kPerRound; ++i) {
    PoseGraphNode node = rounds.node(i);
    node.is_fixed = true;
    node.t_M_B = test::Truth(i).t;
    node.psi = i < kPerRound ? 0 : -2;
    parts.push_back({node, true});
  }
  PoseGraph graph = PoseGraph::FromParts(PoseGraphOptions{}, parts, {TrueLoop(3, 3 + kPerRound)});
  for (int i = 0; i < kPerRound; ++i) {
    graph.AddNode(2, test::Truth(i));
  }
  graph.AddLoop(WrongLoop(7, 2 * kPerRound + 7, kWrong));
  ASSERT_TRUE(graph.AreJoined(1, 2));
  EXPECT_EQ(graph.Separate(2).size(), 1U);
  EXPECT_TRUE(graph.AreJoined(0, 1));
  EXPECT_FALSE(graph.AreJoined(0, 2));
  EXPECT_LT((graph.node(kPerRound + 3).t_M_B - test::Truth(3).t).norm(), 1e-9);
}

}  // namespace
}  // namespace deja_view
