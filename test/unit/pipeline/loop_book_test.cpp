#include "loop_book.hpp"

#include "deja_view/base/angles.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr int kPerRound = 40;

/// Pose `i` of a circle of 2 m radius: 0.31 m of path per pose.
Rigid3 Truth(int i) {
  const double angle = 2.0 * kPi * i / kPerRound;
  return {FromYaw(angle), {2 * std::cos(angle), 2 * std::sin(angle), 1}};
}

/// Two rounds of perfect odometry, the second one in another world if `is_apart`.
PoseGraph MakeGraph(bool is_apart = false) {
  PoseGraph graph{PoseGraphOptions{}};
  const Rigid3 other_world{FromYaw(2), {50, 20, 5}};
  for (int i = 0; i < 2 * kPerRound; ++i) {
    const bool is_other = is_apart && i >= kPerRound;
    graph.AddNode(is_other ? 1 : 0, is_other ? other_world * Truth(i) : Truth(i));
  }
  return graph;
}

/// The loop from i to i + 40, off by `error`.
LoopReport Loop(int i, const Rigid3& error = {}) {
  LoopReport loop;
  loop.old = i;
  loop.current = i + kPerRound;
  loop.T_Bold_Bcurrent = Truth(i).Inverse() * error * Truth(i + kPerRound);
  loop.covariance = 1e-5 * Matrix6d::Identity();
  return loop;
}

std::vector<int> OldOf(const std::vector<LoopReport>& loops) {
  std::vector<int> old;
  for (const LoopReport& loop : loops) {
    old.push_back(loop.old);
  }
  return old;
}

TEST(LoopBook, LoopsWaitUntilOthersAgree) {
  PoseGraph graph = MakeGraph();
  LoopBook book({});
  for (const int i : {3, 5}) {
    const LoopBook::Entry entry = book.Enter(Loop(i), &graph);
    EXPECT_EQ(entry.reason, RejectReason::kInconsistent);
    EXPECT_THAT(entry.believed, IsEmpty());
  }
  EXPECT_EQ(book[0].state, LoopConsistency::State::kPending);
  EXPECT_EQ(book[0].report.reason, RejectReason::kInconsistent);
  EXPECT_THAT(book.Accepted(), IsEmpty());
  EXPECT_TRUE(graph.loops().empty());

  const LoopBook::Entry entry = book.Enter(Loop(7), &graph);
  EXPECT_EQ(entry.reason, RejectReason::kNone);
  EXPECT_THAT(entry.believed, ElementsAre(0, 1, 2));
  EXPECT_FALSE(entry.joins);
  EXPECT_EQ(graph.loops().size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(book[i].edge, i);
    EXPECT_EQ(book[i].state, LoopConsistency::State::kAccepted);
    EXPECT_TRUE(book[i].report.accepted());
    EXPECT_EQ(graph.loop(i).from, book[i].report.old);
  }
}

TEST(LoopBook, AcceptedLoopsStandInTheGraphsOrder) {
  PoseGraph graph = MakeGraph();
  LoopBook book({});
  const Rigid3 error{Eigen::Quaterniond::Identity(), {0, 0.4, 0}};
  book.Enter(Loop(2, error), &graph);  // fits none of the others
  for (const int i : {3, 5, 7, 9}) {
    book.Enter(Loop(i), &graph);
  }
  EXPECT_THAT(OldOf(book.Accepted()), ElementsAre(3, 5, 7, 9));
  EXPECT_EQ(book[0].edge, -1);
  EXPECT_EQ(book[1].edge, 0);
  EXPECT_EQ(book.size(), 5);
}

TEST(LoopBook, TellsWhyALoopIsNotBelieved) {
  PoseGraph graph = MakeGraph();
  LoopBook book({});
  const Rigid3 far{Eigen::Quaterniond::Identity(), {0, 5, 0}};
  EXPECT_EQ(book.Enter(Loop(3, far), &graph).reason, RejectReason::kImplausible);
  EXPECT_EQ(book[0].state, LoopConsistency::State::kImplausible);
}

TEST(LoopBook, TellsThatWorldsWereJoined) {
  PoseGraph graph = MakeGraph(true);
  LoopConsistencyOptions options;
  options.min_span_over_depth = 0.4;
  LoopBook book(options);
  for (const int i : {3, 5, 7, 9}) {
    EXPECT_FALSE(book.Enter(Loop(i), &graph).joins);
  }
  const LoopBook::Entry entry = book.Enter(Loop(11), &graph);
  EXPECT_TRUE(entry.joins);
  EXPECT_EQ(entry.believed.size(), 5U);
  EXPECT_TRUE(graph.AreJoined(0, 1));
  EXPECT_FALSE(book.Enter(Loop(13), &graph).joins) << "they are one already";
}

TEST(LoopBook, GoesOnWhereALoadedMapEnds) {
  PoseGraph graph = MakeGraph();
  LoopBook first({});
  for (const int i : {3, 5, 7}) {
    first.Enter(Loop(i), &graph);
  }
  LoopBook book({}, first.Accepted());
  EXPECT_EQ(book.size(), 3);
  EXPECT_TRUE(book[2].is_of_map);
  for (const int i : {9, 11, 13}) {
    book.Enter(Loop(i), &graph);
  }
  EXPECT_THAT(OldOf(book.Accepted()), ElementsAre(3, 5, 7, 9, 11, 13));
  EXPECT_EQ(book.NewestLocalised(), 13 + kPerRound);
}

TEST(LoopBook, AWithdrawnLoopIsGone) {
  PoseGraph graph = MakeGraph();
  LoopBook book({});
  for (const int i : {3, 5, 7, 9}) {
    book.Enter(Loop(i), &graph);
  }
  graph.RemoveLoop(book[1].edge);
  const std::vector<LoopReport> withdrawn = book.Withdraw({book[1].edge}, graph);
  ASSERT_EQ(withdrawn.size(), 1U);
  EXPECT_EQ(withdrawn[0].old, 5);
  EXPECT_EQ(withdrawn[0].reason, RejectReason::kWithdrawn);
  EXPECT_FALSE(withdrawn[0].accepted());
  EXPECT_THAT(OldOf(book.Accepted()), ElementsAre(3, 7, 9));
  EXPECT_FALSE(book.Refine({5, 5 + kPerRound, Loop(5).T_Bold_Bcurrent}, &graph));
}

TEST(LoopBook, CountsThePlacesLoops) {
  PoseGraph graph = MakeGraph();
  LoopBook book({});
  const auto again = [&](int i, int later) {
    LoopReport loop = Loop(i);
    loop.current += later;
    loop.T_Bold_Bcurrent = Truth(i).Inverse() * Truth(loop.current);
    return loop;
  };
  book.Enter(Loop(3), &graph);
  book.Enter(Loop(5), &graph);
  EXPECT_EQ(book.CountOf(5), 0) << "it waits";
  book.Enter(Loop(7), &graph);
  book.Enter(again(5, 1), &graph);
  EXPECT_EQ(book.CountOf(5), 2);
  EXPECT_EQ(book.CountOf(3), 1);
  EXPECT_EQ(book.CountOf(4), 0);
  graph.RemoveLoop(book[1].edge);
  book.Withdraw({book[1].edge}, graph);
  EXPECT_EQ(book.CountOf(5), 1);
}

TEST(LoopBook, KeepsWhatIsOfUse) {
  PoseGraph graph = MakeGraph();
  LoopConsistencyOptions options;
  options.window = options.span_window = 8;
  LoopBook book(options);
  const Rigid3 error{Eigen::Quaterniond::Identity(), {0, 0.4, 0}};
  for (int i = 0; i < 30; ++i) {
    book.Enter(Loop(i, i % 10 == 0 ? error : Rigid3()), &graph);
  }
  EXPECT_THAT(OldOf(book.Accepted()), testing::SizeIs(27));
  EXPECT_EQ(book.kept(), 27U) << "those that nothing will become of are forgotten";
  std::vector<int> edges;
  for (const auto& [id, loop] : graph.loops()) {
    edges.push_back(id);
  }
  book.Settle(edges, graph);
  EXPECT_THAT(book.Accepted(), IsEmpty());
  EXPECT_LE(book.kept(), 8U);
}

TEST(LoopBook, TakesBackAJoinThatMorePlacesContradict) {
  PoseGraph graph = MakeGraph(true);
  LoopConsistencyOptions options;
  options.min_span_over_depth = 0.4;
  LoopBook book(options);
  const Rigid3 far{Eigen::Quaterniond::Identity(), {0, 5, 0}};
  for (const int i : {0, 2, 4, 6, 8}) {
    book.Enter(Loop(i, far), &graph);
  }
  ASSERT_TRUE(graph.AreJoined(0, 1));
  graph.Solve();
  const int first_edge = book[0].edge;
  graph.RemoveLoop(first_edge);  // as if it had become a tie
  book.Settle({first_edge}, graph);
  for (const int i : {14, 16, 18, 20, 22}) {
    const LoopBook::Entry entry = book.Enter(Loop(i), &graph);
    EXPECT_FALSE(entry.separates);
    EXPECT_THAT(entry.withdrawn, IsEmpty());
    EXPECT_NE(entry.reason, RejectReason::kNone);
  }
  const LoopBook::Entry entry = book.Enter(Loop(24), &graph);
  EXPECT_TRUE(entry.separates);
  EXPECT_TRUE(entry.joins);
  EXPECT_EQ(entry.reason, RejectReason::kNone);
  EXPECT_THAT(OldOf(entry.withdrawn), testing::UnorderedElementsAre(0, 2, 4, 6, 8));
  for (const LoopReport& loop : entry.withdrawn) {
    EXPECT_EQ(loop.current, loop.old + kPerRound);
    EXPECT_EQ(loop.reason, RejectReason::kWithdrawn);
    EXPECT_EQ(book.CountOf(loop.old), 0);
  }
  EXPECT_THAT(OldOf(book.Accepted()), ElementsAre(14, 16, 18, 20, 22, 24));
  EXPECT_TRUE(graph.AreJoined(0, 1));
  EXPECT_LT((graph.node(kPerRound).t_M_B - graph.node(0).t_M_B).norm(), 1e-6);
  EXPECT_FALSE(book.Enter(Loop(26), &graph).separates);
}

TEST(LoopBook, RefinesAnAcceptedLoopByANearbyMeasurement) {
  PoseGraph graph = MakeGraph();
  LoopBook book({});
  for (const int i : {3, 5, 7}) {
    book.Enter(Loop(i), &graph);
  }
  book.Enter(Loop(9, {Eigen::Quaterniond::Identity(), {0, 5, 0}}), &graph);
  const auto moved = [&](int i, double by) {
    Rigid3 T = Loop(i).T_Bold_Bcurrent;
    T.t.x() += by;
    return T;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(book.Refine({5, 5 + kPerRound, moved(5, 0.6)}, &graph));
  EXPECT_FALSE(book.Refine({5, 5 + kPerRound, moved(5, nan)}, &graph));
  EXPECT_FALSE(book.Refine({5, 6 + kPerRound, moved(5, 0)}, &graph)) << "no such loop";
  EXPECT_FALSE(book.Refine({9, 9 + kPerRound, moved(9, 0)}, &graph)) << "not in the graph";
  EXPECT_TRUE(book.CanRefine({5, 5 + kPerRound, moved(5, 0.1)}, graph));
  EXPECT_EQ(graph.loop(1).T_from_to.t, moved(5, 0).t);
  EXPECT_TRUE(book.Refine({5, 5 + kPerRound, moved(5, 0.1)}, &graph));
  EXPECT_EQ(graph.loop(1).T_from_to.t, moved(5, 0.1).t);
  EXPECT_EQ(book.Accepted()[1].T_Bold_Bcurrent.t, moved(5, 0.1).t);
  EXPECT_EQ(graph.loop(0).T_from_to.t, moved(3, 0).t);
}

}  // namespace
}  // namespace deja_view
