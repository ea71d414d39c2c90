#include "solve_schedule.hpp"

#include <utility>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

/// A straight line whose odometry is a tenth too long, keyframes 0.5 m apart.
PoseGraph Line(int nodes) {
  PoseGraph graph{PoseGraphOptions{}};
  for (int i = 0; i < nodes; ++i) {
    graph.AddNode(0, {Eigen::Quaterniond::Identity(), {0.55 * i, 0, 0}});
  }
  return graph;
}

/// From the first to the last node of a line, `error_m` more than the graph has it.
PoseGraphLoop LoopOver(const PoseGraph& graph, double error_m) {
  PoseGraphLoop loop;
  loop.from = 0;
  loop.to = graph.size() - 1;
  loop.T_from_to.t = graph.node(graph.size() - 1).T_W_B.t + Eigen::Vector3d(error_m, 0, 0);
  loop.covariance = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
  return loop;
}

void Note(double error_m, bool joins, PoseGraph* graph, SolveSchedule* schedule) {
  const PoseGraphLoop loop = LoopOver(*graph, error_m);
  graph->AddLoop(loop);
  schedule->NoteLoop(loop, joins, *graph);
}

/// Whether a solution is due at the next keyframe but one.
bool IsSolved(SolveSchedule* schedule, PoseGraph* graph) {
  schedule->StartIfDue(*graph);
  graph->AddNode(0, {Eigen::Quaterniond::Identity(), {0.55 * graph->size(), 0, 0}});
  EXPECT_FALSE(schedule->TakeIfDue(graph)) << "a latency of two keyframes";
  graph->AddNode(0, {Eigen::Quaterniond::Identity(), {0.55 * graph->size(), 0, 0}});
  return schedule->TakeIfDue(graph);
}

TEST(SolveSchedule, SolvesAfterEnoughLoops) {
  SolveOptions options;
  options.every_loops = 3;
  SolveSchedule schedule(options, {});
  PoseGraph graph = Line(6);
  for (int i = 0; i < 2; ++i) {
    Note(0.0, false, &graph, &schedule);
  }
  EXPECT_FALSE(IsSolved(&schedule, &graph));
  graph = Line(6);
  Note(0.0, false, &graph, &schedule);
  EXPECT_TRUE(IsSolved(&schedule, &graph));
  EXPECT_FALSE(IsSolved(&schedule, &graph)) << "it counts anew";
}

TEST(SolveSchedule, SolvesAtOnceWhenSurprised) {
  for (const bool joins : {false, true}) {
    for (const double error : {0.0, -0.5}) {
      SolveSchedule schedule(SolveOptions{}, {});
      PoseGraph graph = Line(6);
      Note(error, joins, &graph, &schedule);
      EXPECT_EQ(IsSolved(&schedule, &graph), joins || error != 0.0);
    }
  }
}

TEST(SolveSchedule, TakesTheSolutionOver) {
  SolveSchedule schedule(SolveOptions{}, {});
  PoseGraph graph = Line(6);
  Note(-0.3, true, &graph, &schedule);
  ASSERT_TRUE(IsSolved(&schedule, &graph));
  EXPECT_LT(graph.node(5).t_M_B.x(), 5 * 0.55 - 0.005);
  EXPECT_NEAR(graph.node(7).t_M_B.x() - graph.node(5).t_M_B.x(), 2 * 0.55, 1e-9)
      << "newer nodes follow by odometry";
}

TEST(SolveSchedule, WaitsLongerWithALargerGraph) {
  SolveOptions options;
  options.nodes_per_latency = 5;
  SolveSchedule schedule(options, {});
  PoseGraph graph = Line(10);  // two keyframes more
  Note(-0.3, true, &graph, &schedule);
  schedule.StartIfDue(graph);
  int keyframes = 0;
  do {
    graph.AddNode(0, {Eigen::Quaterniond::Identity(), {0.55 * graph.size(), 0, 0}});
    ++keyframes;
  } while (!schedule.TakeIfDue(&graph) && keyframes < 20);
  EXPECT_EQ(keyframes, 4);
}

TEST(SolveSchedule, HandsTheWorkToTheExecutorAndWaitsForIt) {
  std::vector<std::function<void()>> jobs;
  std::promise<void> done;
  const SolveExecutor executor = [&](std::function<void()> job) {
    jobs.push_back(std::move(job));
    return done.get_future();
  };
  SolveSchedule schedule(SolveOptions{}, executor);
  PoseGraph graph = Line(6);
  Note(-0.3, true, &graph, &schedule);
  schedule.StartIfDue(graph);
  Note(-0.3, true, &graph, &schedule);
  schedule.StartIfDue(graph);
  ASSERT_EQ(jobs.size(), 1U) << "one at a time";
  jobs[0]();
  done.set_value();
  EXPECT_EQ(graph.node(5).t_M_B.x(), 5 * 0.55) << "not taken over yet";
  schedule.Finish(&graph);
  EXPECT_LT(graph.node(5).t_M_B.x(), 5 * 0.55 - 0.005);
}

TEST(SolveSchedule, ForgetsOnReset) {
  SolveSchedule schedule(SolveOptions{}, {});
  PoseGraph graph = Line(6);
  Note(-0.5, true, &graph, &schedule);
  schedule.Reset();
  EXPECT_FALSE(IsSolved(&schedule, &graph));
}

/// Of a graph that came apart the loops of a solution under way may be gone.
TEST(SolveSchedule, AfterARestartTheSolutionUnderWayIsVoid) {
  SolveSchedule schedule(SolveOptions{}, {});
  PoseGraph graph = Line(6);
  Note(-0.5, true, &graph, &schedule);
  schedule.StartIfDue(graph);
  ASSERT_TRUE(schedule.is_pending());
  graph.RemoveLoop(0);
  schedule.Restart();
  EXPECT_FALSE(schedule.is_pending());
  EXPECT_TRUE(schedule.has_news());
  EXPECT_TRUE(IsSolved(&schedule, &graph)) << "at once, whatever the number of loops";
  EXPECT_LT((graph.node(5).t_M_B - graph.node(5).T_W_B.t).norm(), 1e-12);
}

}  // namespace
}  // namespace deja_view
