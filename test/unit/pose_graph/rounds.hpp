// Rounds of a circle, in one world or two, and loops between the rounds.
#pragma once

#include "deja_view/base/angles.hpp"
#include "deja_view/pose_graph/loop_consistency.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace deja_view::test {

inline constexpr int kPerRound = 40;

/// Pose `i` of a circle of 2 m radius: 0.31 m of path per pose.
inline Rigid3 Truth(int i) {
  const double angle = 2.0 * kPi * i / kPerRound;
  return {FromYaw(angle) * ExpSo3({0.1, 0.05, 0}),
          {2 * std::cos(angle), 2 * std::sin(angle), 1 + 0.1 * std::sin(3 * angle)}};
}

inline PoseGraphLoop TrueLoop(int from, int to) {
  PoseGraphLoop loop;
  loop.from = from;
  loop.to = to;
  loop.T_from_to = Truth(from).Inverse() * Truth(to);
  loop.covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-5;
  return loop;
}

/// All wrong loops with the same `error` (in the world) agree with each other.
inline PoseGraphLoop WrongLoop(int from, int to, const Rigid3& error) {
  PoseGraphLoop loop = TrueLoop(from, to);
  loop.T_from_to = Truth(from).Inverse() * error * Truth(to);
  return loop;
}

/// Adds loops from i to i + 40 for each i, accepted ones to the graph too; returns the accepted
/// tags.
inline std::vector<int> AddTrueLoops(const std::vector<int>& from,
                                     LoopConsistency* consistency,
                                     PoseGraph* graph) {
  std::vector<int> tags;
  for (const int i : from) {
    for (const auto& entry : consistency->Add(TrueLoop(i, i + kPerRound), i, *graph).believed) {
      EXPECT_EQ(entry.state, LoopConsistency::State::kAccepted);
      graph->AddLoop(entry.loop);
      tags.push_back(entry.tag);
    }
  }
  return tags;
}

/// Two worlds of one round each.
inline PoseGraph MakeTwoWorlds(bool is_map = false) {
  PoseGraph graph{PoseGraphOptions{}};
  const Rigid3 other_world{FromYaw(2), {50, 20, 5}};
  for (int i = 0; i < 2 * kPerRound; ++i) {
    const bool is_first = i < kPerRound;
    graph.AddNode(i / kPerRound, is_first ? Truth(i) : other_world * Truth(i), is_map && is_first);
  }
  return graph;
}

}  // namespace deja_view::test
