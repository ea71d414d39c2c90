#include "deja_view/base/check.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr int kLap = 100;        // keyframes per round
constexpr int kPlaceEvery = 10;  // of the first round

/// Rounds of a circle of 4 m radius.
Rigid3 OnCircle(int i) {
  const double angle = 2.0 * 3.14159265358979 * i / kLap;
  return {FromYaw(angle), {4 * std::cos(angle), 4 * std::sin(angle), 1}};
}

/// Flies rounds with a drifting odometry, a loop to a place from every second keyframe of later
/// rounds, as the loop closer does: solved every 30 keyframes, and then reduced.
class Rounds {
 public:
  explicit Rounds(int window) : graph_(Options(window)) {}

  void Fly(int keyframes) {
    for (int i = 0; i < keyframes; ++i) {
      const int k = graph_.size();
      if (k > 0) {
        vio_ = vio_ * (OnCircle(k - 1).Inverse() * OnCircle(k)) *
               Rigid3{FromYaw(6e-4 * normal_(rng_)), 0.004 * Noise()};
      }
      graph_.AddNode(0, vio_);
      if (k < kLap && k % kPlaceEvery == 0) {
        graph_.Keep(k);
      }
      if (k >= kLap && k % 2 == 0) {
        graph_.AddLoop(Loop((k % kLap + kPlaceEvery / 2) / kPlaceEvery * kPlaceEvery % kLap, k));
      }
      if (k % 30 == 29) {
        graph_.Solve();
        settled_ = graph_.Reduce();
        absorbed_ += settled_.absorbed.size();
        withdrawn_ += settled_.withdrawn.size();
      }
    }
  }

  PoseGraphLoop Loop(int from, int to) {
    PoseGraphLoop loop;
    loop.from = from;
    loop.to = to;
    loop.T_from_to = OnCircle(from).Inverse() * OnCircle(to);
    loop.T_from_to.t += 0.01 * Noise();
    loop.covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4;
    loop.covariance.bottomRightCorner<3, 3>() *= 0.04;
    return loop;
  }

  /// RMS position error [m] with the first pose aligned.
  double Error() const {
    const Rigid3 T_M_truth = graph_.node(0).T_M_B() * OnCircle(0).Inverse();
    double sum = 0;
    for (int i = 0; i < graph_.size(); ++i) {
      sum += (graph_.node(i).t_M_B - T_M_truth * OnCircle(i).t).squaredNorm();
    }
    return std::sqrt(sum / graph_.size());
  }

  PoseGraph graph_;
  PoseGraph::Settled settled_;
  std::size_t absorbed_ = 0;
  std::size_t withdrawn_ = 0;

 private:
  static PoseGraphOptions Options(int window) {
    PoseGraphOptions options;
    options.window = window;
    return options;
  }
  Eigen::Vector3d Noise() { return {normal_(rng_), normal_(rng_), normal_(rng_)}; }

  std::mt19937 rng_{1};
  std::normal_distribution<double> normal_;
  Rigid3 vio_ = OnCircle(0);
};

TEST(PoseGraphReduction, WithoutLoopsNothingMovesWhenNodesGo) {
  Rounds rounds(20);
  rounds.Fly(90);
  EXPECT_FALSE(rounds.graph_.IsLive(15));
  EXPECT_TRUE(rounds.graph_.IsLive(20)) << "a place";
  EXPECT_TRUE(rounds.graph_.IsLive(0)) << "the first one";
  EXPECT_EQ(rounds.graph_.window_size(), 20U);
  for (int i = 0; i < 90; ++i) {
    EXPECT_LT((rounds.graph_.node(i).t_M_B - rounds.graph_.node(i).T_W_B.t).norm(), 1e-9) << i;
  }
  // Ten steps of odometry between two places are one tie that knows what they knew.
  const PoseGraphTie& tie = rounds.graph_.ties().at({20, 30});
  const Rigid3 T_20_30 = rounds.graph_.node(20).T_W_B.Inverse() * rounds.graph_.node(30).T_W_B;
  EXPECT_LT((tie.t_I_J - T_20_30.t).norm(), 1e-9);
  const double yaw_sigma_deg = 0.2 * std::sqrt(rounds.graph_.PathLength(20, 30));
  const double yaw_variance = tie.information.inverse()(3, 3);
  EXPECT_NEAR(std::sqrt(yaw_variance) * 180 / 3.14159265, yaw_sigma_deg, 0.02 * yaw_sigma_deg);
}

TEST(PoseGraphReduction, KeepsTheInformation) {
  Rounds whole(0);
  Rounds reduced(60);
  whole.Fly(600);
  reduced.Fly(600);
  whole.graph_.Solve();
  reduced.graph_.Solve();
  EXPECT_EQ(whole.graph_.live_size(), 600U);
  EXPECT_LT(reduced.graph_.live_size(), 100U);
  EXPECT_GT(reduced.absorbed_, 200U);
  EXPECT_EQ(reduced.withdrawn_, 0U);
  EXPECT_LT(reduced.Error(), 1.2 * whole.Error());
  for (int place = 0; place < kLap; place += kPlaceEvery) {
    EXPECT_LT((reduced.graph_.node(place).t_M_B - whole.graph_.node(place).t_M_B).norm(), 0.006);
  }
}

TEST(PoseGraphReduction, DoesNotGrowWhereThePlaceIsKnown) {
  Rounds rounds(60);
  rounds.Fly(400);
  const std::size_t live = rounds.graph_.live_size();
  const std::size_t ties = rounds.graph_.ties().size();
  const std::size_t loops = rounds.graph_.loops().size();
  rounds.Fly(1500);
  EXPECT_LT(rounds.graph_.live_size(), live + 30);
  EXPECT_LT(rounds.graph_.ties().size(), ties + 60);
  EXPECT_LT(rounds.graph_.loops().size(), loops + 30);
  EXPECT_EQ(rounds.graph_.size(), 1900);
}

TEST(PoseGraphReduction, ADroppedNodeGoesWithThePlacesAroundIt) {
  Rounds rounds(20);
  rounds.Fly(90);
  const Eigen::Vector3d before = rounds.graph_.node(15).t_M_B;
  const Rigid3 T_10_15 = rounds.graph_.node(10).T_M_B().Inverse() * rounds.graph_.node(15).T_M_B();
  // A loop tells that the circle is turned.
  PoseGraphLoop loop = rounds.Loop(0, 89);
  loop.T_from_to.t += Eigen::Vector3d(0.2, 0.1, 0);
  rounds.graph_.AddLoop(loop);
  rounds.graph_.Solve();
  const Rigid3 T_10_15_after =
      rounds.graph_.node(10).T_M_B().Inverse() * rounds.graph_.node(15).T_M_B();
  EXPECT_GT((rounds.graph_.node(15).t_M_B - before).norm(), 0.005);
  EXPECT_LT((T_10_15_after.t - T_10_15.t).norm(), 0.02);
}

TEST(PoseGraphReduction, ALoopOfADroppedNodeIsOneOfItsPlace) {
  Rounds rounds(20);
  rounds.Fly(290);
  ASSERT_FALSE(rounds.graph_.IsLive(151));
  const int id = rounds.graph_.AddLoop(rounds.Loop(80, 151));
  ASSERT_EQ(rounds.graph_.loops().count(id), 1U);
  EXPECT_TRUE(rounds.graph_.IsLive(rounds.graph_.loop(id).to));
  EXPECT_LT(std::sqrt(rounds.graph_.SquaredError(rounds.graph_.loop(id))), 5.0);
}

TEST(PoseGraphReduction, WithdrawsWhatTwoSolutionsInARowContradict) {
  Rounds rounds(0);
  rounds.Fly(200);
  PoseGraphLoop wrong = rounds.Loop(0, 199);
  wrong.T_from_to.t.x() += 1.0;
  const int id = rounds.graph_.AddLoop(wrong);
  rounds.graph_.Solve();
  EXPECT_LT(rounds.graph_.loop(id).weight, 0.05);
  EXPECT_THAT(rounds.graph_.WithdrawContradicted(2), testing::IsEmpty());
  rounds.graph_.Solve();
  EXPECT_THAT(rounds.graph_.WithdrawContradicted(2), testing::ElementsAre(id));
  EXPECT_EQ(rounds.graph_.loops().count(id), 0U);
  EXPECT_EQ(rounds.graph_.loops().size(), 50U);
  rounds.graph_.Solve();
}

TEST(PoseGraphReduction, ASolutionThatAgreesForgivesTheOneBefore) {
  Rounds rounds(0);
  rounds.Fly(200);
  const PoseGraphLoop right = rounds.Loop(0, 199);
  Rigid3 wrong = right.T_from_to;
  wrong.t.x() += 1.0;
  const int id = rounds.graph_.AddLoop(right);
  for (const Rigid3& T_from_to : {wrong, right.T_from_to, wrong}) {
    rounds.graph_.UpdateLoop(id, T_from_to);
    rounds.graph_.Solve();
    EXPECT_THAT(rounds.graph_.WithdrawContradicted(2), testing::IsEmpty());
  }
  EXPECT_THAT(rounds.graph_.WithdrawContradicted(1), testing::ElementsAre(id));
}

TEST(PoseGraphReduction, AbsorbsNoLoopThatIsSwitchedOff) {
  Rounds rounds(60);
  rounds.Fly(199);
  PoseGraphLoop wrong = rounds.Loop(20, 150);
  wrong.T_from_to.t.z() += 1.0;
  const int id = rounds.graph_.AddLoop(wrong);
  rounds.Fly(60);
  EXPECT_EQ(rounds.withdrawn_, 1U);
  EXPECT_EQ(rounds.graph_.loops().count(id), 0U);
  EXPECT_LT(rounds.Error(), 0.03);
}

TEST(PoseGraphReduction, APartOfTheGraphIsSolvedAlone) {
  Rounds rounds(0);
  rounds.Fly(200);
  PoseGraphProblem problem = rounds.graph_.Problem(50);
  std::size_t free = 0;
  for (const PoseGraphProblem::Node& node : problem.nodes) {
    free += node.is_constant ? 0 : 1;
  }
  EXPECT_GE(free, 49U);
  EXPECT_LE(free, 50U);
  const Eigen::Vector3d t_130 = rounds.graph_.node(130).t_M_B;
  PoseGraphLoop loop = rounds.Loop(0, 199);
  loop.T_from_to.t.x() += 0.05;
  rounds.graph_.AddLoop(loop);
  const Eigen::Vector3d t_199 = rounds.graph_.node(199).t_M_B;
  problem = rounds.graph_.Problem(20);
  problem.Solve();
  rounds.graph_.TakeSolution(problem);
  EXPECT_NE(rounds.graph_.node(199).t_M_B, t_199);
  EXPECT_EQ(rounds.graph_.node(130).t_M_B, t_130);
}

}  // namespace
}  // namespace deja_view
