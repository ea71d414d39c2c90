#include "deja_view/pose_graph/pose_graph.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

/// A circle flown twice, with drift in yaw and position.
struct Flight {
  std::vector<Rigid3> truth;
  std::vector<Rigid3> vio;
};

Flight MakeFlight(int per_round, int rounds, std::uint32_t seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  Flight flight;
  Rigid3 drift;
  for (int i = 0; i < per_round * rounds; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / per_round;
    const Rigid3 T{FromYaw(angle) * ExpSo3({0.1 * std::sin(angle), -1.3, 0}),
                   {4 * std::cos(angle), 4 * std::sin(angle), 1 + 0.2 * std::sin(2 * angle)}};
    flight.truth.push_back(T);
    drift.q = FromYaw(Yaw(drift.q) + 0.0005 * normal(rng) + 0.0003);
    drift.t += 0.004 * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
    flight.vio.push_back(drift * T);
  }
  return flight;
}

PoseGraphLoop TrueLoop(const Flight& flight, int from, int to) {
  PoseGraphLoop loop;
  loop.from = from;
  loop.to = to;
  loop.T_from_to = flight.truth[static_cast<std::size_t>(from)].Inverse() *
                   flight.truth[static_cast<std::size_t>(to)];
  loop.covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4;
  return loop;
}

/// Largest position error after moving both to the first pose.
double LargestError(const PoseGraph& graph, const Flight& flight) {
  const Rigid3 T_M_truth = graph.node(0).T_M_B() * flight.truth.front().Inverse();
  double largest = 0;
  for (int i = 0; i < graph.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    largest = std::max(largest, (graph.node(i).t_M_B - T_M_truth * flight.truth[k].t).norm());
  }
  return largest;
}

PoseGraph MakeGraph(const Flight& flight) {
  PoseGraph graph{PoseGraphOptions{}};
  for (const Rigid3& T_W_B : flight.vio) {
    graph.AddNode(0, T_W_B);
  }
  return graph;
}

TEST(PoseGraph, KeepsTheOdometryWithoutLoops) {
  const Flight flight = MakeFlight(40, 1, 1);
  PoseGraph graph = MakeGraph(flight);
  graph.Solve();
  for (int i = 0; i < graph.size(); ++i) {
    EXPECT_LT((graph.node(i).t_M_B - flight.vio[static_cast<std::size_t>(i)].t).norm(), 1e-9);
  }
}

TEST(PoseGraph, LoopsTakeTheDriftAway) {
  const Flight flight = MakeFlight(100, 2, 2);
  PoseGraph graph = MakeGraph(flight);
  const double before = LargestError(graph, flight);
  for (int i = 0; i < 100; i += 5) {
    graph.AddLoop(TrueLoop(flight, i, i + 100));
  }
  const auto summary = graph.Solve();
  EXPECT_GT(before, 0.15);
  EXPECT_LT(LargestError(graph, flight), 0.6 * before);
  for (const auto& [id, loop] : graph.loops()) {
    EXPECT_LT(std::sqrt(graph.SquaredError(loop)), 2.0);
    EXPECT_GT(loop.weight, 0.5);
  }
  EXPECT_EQ(summary.nodes, 200);
}

TEST(PoseGraph, WrongLoopsDoNotBendTheMap) {
  const Flight flight = MakeFlight(100, 2, 3);
  PoseGraph clean = MakeGraph(flight);
  PoseGraph dirty = MakeGraph(flight);
  for (int i = 0; i < 100; i += 5) {
    clean.AddLoop(TrueLoop(flight, i, i + 100));
    dirty.AddLoop(TrueLoop(flight, i, i + 100));
  }
  for (int i = 2; i < 40; i += 10) {
    PoseGraphLoop wrong = TrueLoop(flight, i, i + 100);
    wrong.T_from_to.t += Eigen::Vector3d(1.5, -0.7, 0.3);
    dirty.AddLoop(wrong);
  }
  clean.Solve();
  dirty.Solve();
  for (int i = 0; i < clean.size(); ++i) {
    EXPECT_LT((clean.node(i).t_M_B - dirty.node(i).t_M_B).norm(), 0.01);
  }
  EXPECT_LT(dirty.loops().rbegin()->second.weight, 0.01);
}

TEST(PoseGraph, JoinsASecondSequenceAtItsFirstLoop) {
  const Flight flight = MakeFlight(60, 2, 4);
  PoseGraph graph{PoseGraphOptions{}};
  const Rigid3 other_world{FromYaw(2.0), {10, -5, 3}};
  for (int i = 0; i < 60; ++i) {
    graph.AddNode(0, flight.vio[static_cast<std::size_t>(i)], true);
  }
  for (int i = 60; i < 120; ++i) {
    graph.AddNode(1, other_world * flight.vio[static_cast<std::size_t>(i)]);
  }
  EXPECT_FALSE(graph.IsAnchored(1));
  graph.AddLoop(TrueLoop(flight, 10, 70));
  EXPECT_TRUE(graph.IsAnchored(1));
  EXPECT_LT(std::sqrt(graph.SquaredError(graph.loop(0))), 0.5);
  graph.AddLoop(TrueLoop(flight, 50, 110));
  graph.Solve();
  const Rigid3 T_0_60 = graph.node(0).T_M_B().Inverse() * graph.node(60).T_M_B();
  EXPECT_LT((T_0_60.t - (flight.truth[0].Inverse() * flight.truth[60]).t).norm(), 0.1);
  EXPECT_LT((graph.node(30).t_M_B - flight.vio[30].t).norm(), 1e-12) << "a fixed node moved";
}

TEST(PoseGraph, CorrectsASequenceThatNothingJoinsToTheFirst) {
  const Flight flight = MakeFlight(60, 2, 8);
  PoseGraph graph{PoseGraphOptions{}};
  graph.AddNode(0, {FromYaw(1.0), {50, 0, 0}});
  for (const Rigid3& T_W_B : flight.vio) {
    graph.AddNode(1, T_W_B);
  }
  for (int i = 0; i < 60; i += 5) {
    PoseGraphLoop loop = TrueLoop(flight, i, i + 60);
    ++loop.from;
    ++loop.to;
    graph.AddLoop(loop);
  }
  const double before = graph.SquaredError(graph.loops().rbegin()->second);
  graph.Solve();
  EXPECT_FALSE(graph.IsAnchored(1));
  EXPECT_LT(graph.SquaredError(graph.loops().rbegin()->second), 0.2 * before);
  EXPECT_EQ(graph.node(1).t_M_B, flight.vio[0].t) << "its first node holds its world";
}

TEST(PoseGraph, TakesTheSolutionOfASnapshot) {
  const Flight flight = MakeFlight(60, 2, 5);
  PoseGraph graph{PoseGraphOptions{}};
  for (int i = 0; i < 100; ++i) {
    graph.AddNode(0, flight.vio[static_cast<std::size_t>(i)]);
  }
  graph.AddLoop(TrueLoop(flight, 20, 80));
  PoseGraphProblem problem = graph.Problem();
  graph.AddNode(0, flight.vio[100]);
  const Rigid3 T_99_100 = graph.node(99).T_M_B().Inverse() * graph.node(100).T_M_B();
  const Eigen::Vector3d t_50 = graph.node(50).t_M_B;
  problem.Solve();
  graph.TakeSolution(problem);
  EXPECT_NE(graph.node(50).t_M_B, t_50);
  const Rigid3 after = graph.node(99).T_M_B().Inverse() * graph.node(100).T_M_B();
  EXPECT_LT((T_99_100.t - after.t).norm(), 1e-9);
}

TEST(PoseGraph, ASolutionDoesNotUndoAJoinMadeMeanwhile) {
  const Flight flight = MakeFlight(60, 2, 7);
  PoseGraph graph{PoseGraphOptions{}};
  for (int i = 0; i < 120; ++i) {
    graph.AddNode(i / 60, flight.vio[static_cast<std::size_t>(i)]);
  }
  PoseGraphProblem problem = graph.Problem();
  graph.AddLoop(TrueLoop(flight, 10, 70));
  const Eigen::Vector3d joined = graph.node(90).t_M_B;
  problem.Solve();
  graph.TakeSolution(problem);
  EXPECT_EQ(graph.node(90).t_M_B, joined);
}

TEST(PoseGraph, SolvesTheSameBitsTwice) {
  const Flight flight = MakeFlight(60, 2, 6);
  PoseGraph a = MakeGraph(flight);
  for (int i = 0; i < 60; i += 7) {
    a.AddLoop(TrueLoop(flight, i, i + 60));
  }
  PoseGraph b = a;
  a.Solve();
  b.Solve();
  for (int i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.node(i).t_M_B, b.node(i).t_M_B);
  }
}

std::vector<PoseGraph::Part> PartsOf(const PoseGraph& graph, int every) {
  std::vector<PoseGraph::Part> parts;
  for (int i = 0; i < graph.size(); ++i) {
    parts.push_back({graph.node(i), i % every == 0});
    parts.back().node.is_fixed = true;
  }
  return parts;
}

TEST(PoseGraph, IsRestoredFromItsParts) {
  const Flight flight = MakeFlight(60, 3, 8);
  PoseGraph graph{PoseGraphOptions{}};
  for (int i = 0; i < 180; ++i) {
    graph.AddNode(i / 60, flight.vio[static_cast<std::size_t>(i)]);
  }
  std::vector<PoseGraphLoop> loops;
  for (int i = 5; i < 60; i += 10) {
    loops.push_back(TrueLoop(flight, i, i + 60));
    graph.AddLoop(loops.back());
  }
  graph.Solve();
  const PoseGraph restored = PoseGraph::FromParts(graph.options(), PartsOf(graph, 10), loops);
  ASSERT_EQ(restored.size(), graph.size());
  for (int i = 0; i < graph.size(); ++i) {
    EXPECT_LT((restored.node(i).t_M_B - graph.node(i).t_M_B).norm(), 1e-12);
    EXPECT_NEAR(restored.node(i).psi, graph.node(i).psi, 1e-12);
    EXPECT_TRUE(restored.node(i).is_fixed);
    EXPECT_EQ(restored.IsLive(i), i % 10 == 0);
  }
  EXPECT_TRUE(restored.loops().empty()) << "they can't move anything";
  EXPECT_TRUE(restored.AreJoined(0, 1));
  EXPECT_FALSE(restored.IsAnchored(2));
  EXPECT_EQ(restored.PathLength(70, 110), graph.PathLength(70, 110));
}

TEST(PoseGraph, PartsMustFitTogether) {
  const Flight flight = MakeFlight(10, 1, 9);
  const PoseGraph graph = MakeGraph(flight);
  const std::vector<PoseGraph::Part> parts = PartsOf(graph, 1);
  PoseGraphLoop loop = TrueLoop(flight, 1, 5);
  loop.to = 10;
  EXPECT_THROW(PoseGraph::FromParts(graph.options(), parts, {loop}), CheckError);
  loop.to = 5;
  loop.from = -1;
  EXPECT_THROW(PoseGraph::FromParts(graph.options(), parts, {loop}), CheckError);
}

TEST(PoseGraph, ChecksItsArgumentsAndOptions) {
  PoseGraph graph{PoseGraphOptions{}};
  graph.AddNode(0, {});
  PoseGraphLoop loop;
  loop.from = 0;
  loop.to = 1;
  EXPECT_THROW(graph.AddLoop(loop), CheckError);
  PoseGraphOptions options;
  options.kernel_graduation = 1.0;
  options.kernel_scale = -1;
  EXPECT_EQ(options.Validate().size(), 2U);
  EXPECT_TRUE(PoseGraphOptions{}.Validate().empty());
}

}  // namespace
}  // namespace deja_view
