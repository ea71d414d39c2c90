#include "deja_view/geometry/trajectory_alignment.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>
#include <random>

#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A flight of 20 s with 10 poses a second.
Trajectory Flight() {
  Trajectory flight;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.1 * i;
    flight.stamps_ns.push_back(1'000'000'000'000 + i * 100'000'000LL);
    flight.poses.push_back({ExpSo3({0.1 * std::sin(t), 0.1 * std::cos(t), 0.3 * t}),
                            {3 * std::sin(0.5 * t), 2 * std::cos(0.4 * t), 0.5 * std::sin(t)}});
  }
  return flight;
}

// As another system would have it: x_B = B_A x_A with noise, and outliers.
Trajectory Other(const Trajectory& T_A_X, const Similarity3& B_A, double noise, int outliers) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  Trajectory T_B_X = Transform(B_A, T_A_X);
  for (Rigid3& pose : T_B_X.poses) {
    pose.t += noise * Eigen::Vector3d(normal(random), normal(random), normal(random));
  }
  for (int i = 0; i < outliers; ++i) {
    T_B_X.poses[static_cast<std::size_t>(i * 3) % T_B_X.size()].t +=
        Eigen::Vector3d(5 + normal(random), -4, 3 * normal(random));
  }
  return T_B_X;
}

Similarity3 Inverse(const Similarity3& A_B) {
  const Rigid3 inverse{A_B.T_A_B.q.conjugate(), Eigen::Vector3d::Zero()};
  return {1 / A_B.scale, {inverse.q, -(inverse.q * A_B.T_A_B.t) / A_B.scale}};
}

std::string ErrorOf(const Trajectory& a, const Trajectory& b, const AlignmentOptions& options) {
  try {
    AlignTrajectories(a, b, options, "poses.txt");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(AlignTrajectories, FindsASimilarityAmongOutliers) {
  const Trajectory flight = Flight();
  const Similarity3 B_A{0.2, {ExpSo3({1, -0.5, 2}), {10, 20, -30}}};
  AlignmentOptions options;
  options.freedom = AlignmentFreedom::kSimilarity;
  const RobustAlignment found =
      AlignTrajectories(flight, Other(flight, B_A, 0.002, 60), options, "colmap");
  const Similarity3 truth = Inverse(B_A);
  EXPECT_NEAR(found.A_B.scale, truth.scale, 0.01);
  EXPECT_LT(RotationAngle(found.A_B.T_A_B.q.conjugate() * truth.T_A_B.q), 0.005);
  EXPECT_LT(
      (found.A_B * Eigen::Vector3d(10, 20, -30) - truth * Eigen::Vector3d(10, 20, -30)).norm(),
      0.01);
  EXPECT_NEAR(found.inlier_share, 140.0 / 200, 0.01);
  EXPECT_NEAR(found.rmse_m, 0.002 / 0.2 * std::sqrt(3), 0.003);
  EXPECT_GT(found.max_m, 20);
  EXPECT_EQ(found.pairs, 200U);
  EXPECT_LT(found.rotation_rad, 0.005);
}

TEST(AlignTrajectories, KeepsWhatIsNotFree) {
  const Trajectory flight = Flight();
  AlignmentOptions options;
  options.freedom = AlignmentFreedom::kYaw;
  const Similarity3 yaw{1, {FromYaw(2.5), {1, 2, 3}}};
  const RobustAlignment found =
      AlignTrajectories(flight, Other(flight, yaw, 0.01, 40), options, "vio");
  EXPECT_EQ(found.A_B.scale, 1.0);
  EXPECT_NEAR(Yaw(found.A_B.T_A_B.q), -2.5, 0.005);
  EXPECT_EQ((found.A_B.T_A_B.q * Eigen::Vector3d::UnitZ()).z(), 1.0);
  // A tilt can't be undone by yaw, nor a scale by a rigid motion.
  const Similarity3 tilt{1, {ExpSo3({0.6, 0, 0}), {0, 0, 0}}};
  EXPECT_THAT(ErrorOf(flight, Other(flight, tilt, 0, 0), options), HasSubstr("does not fit"));
  options.freedom = AlignmentFreedom::kRigid;
  EXPECT_EQ(ErrorOf(flight, Other(flight, tilt, 0, 0), options), "no error");
  const Similarity3 scale{2, {}};
  EXPECT_THAT(ErrorOf(flight, Other(flight, scale, 0, 0), options), HasSubstr("does not fit"));
}

TEST(AlignTrajectories, BadFitsAreErrorsWithFigures) {
  const Trajectory flight = Flight();
  AlignmentOptions options;
  EXPECT_THAT(
      ErrorOf(flight, Other(flight, {}, 0.25, 0), options),
      AllOf(HasSubstr("poses.txt: does not fit"), HasSubstr("RMSE"), HasSubstr("200 poses")));
  options.min_inlier_share = 0.8;
  EXPECT_THAT(ErrorOf(flight, Other(flight, {}, 0, 60), options), HasSubstr("70.0 %"));
  // Poses of the camera taken for those of the body: the positions fit, the orientations don't.
  const Rigid3 T_B_C{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0.05, 0, 0}};
  EXPECT_THAT(ErrorOf(flight, Transform(flight, T_B_C), {}), HasSubstr("orientation 120"));
}

TEST(AlignTrajectories, TooLittleIsAnError) {
  const Trajectory flight = Flight();
  Trajectory later = flight;
  for (std::int64_t& stamp_ns : later.stamps_ns) {
    stamp_ns += 19'550'000'000;
  }
  EXPECT_THAT(ErrorOf(flight, later, {}), HasSubstr("4 poses have a common stamp"));
  Trajectory line = flight;
  for (std::size_t i = 0; i < line.size(); ++i) {
    line.poses[i].t = {static_cast<double>(i), 0, 0};
  }
  EXPECT_THAT(ErrorOf(line, line, {}), HasSubstr("one line"));
  AlignmentOptions yaw;
  yaw.freedom = AlignmentFreedom::kYaw;
  EXPECT_EQ(ErrorOf(line, line, yaw), "no error");
  for (Rigid3& pose : line.poses) {
    pose.t = {0, 0, pose.t.x()};
  }
  EXPECT_THAT(ErrorOf(line, line, yaw), HasSubstr("one line"));
}

TEST(AlignTrajectories, InterpolatesAtTheSparserStamps) {
  const Trajectory flight = Flight();
  Trajectory sparse;
  for (std::int64_t stamp_ns = flight.stamps_ns.front() + 50'000'000;
       stamp_ns < flight.stamps_ns.back();
       stamp_ns += 1'000'000'000) {
    sparse.stamps_ns.push_back(stamp_ns);
    sparse.poses.push_back(*flight.At(stamp_ns));
  }
  for (const bool swap : {false, true}) {
    const RobustAlignment found =
        AlignTrajectories(swap ? sparse : flight, swap ? flight : sparse, {}, "sparse");
    EXPECT_EQ(found.pairs, sparse.size());
    EXPECT_LT(found.max_m, 1e-9);
  }
}

TEST(AlignPointsRobustly, RejectsTooFewPointsAndSizesThatDiffer) {
  const std::vector<Eigen::Vector3d> points(4, Eigen::Vector3d::Zero());
  EXPECT_THROW(AlignPointsRobustly({points[0], points[1]}, {points[0], points[1]}, {}), CheckError);
  EXPECT_THROW(AlignPointsRobustly(points, {points[0]}, {}), CheckError);
}

TEST(Transform, TurnsAndScales) {
  Trajectory one;
  one.stamps_ns = {7};
  one.poses = {{FromYaw(0.5), {1, 0, 0}}};
  const Trajectory moved = Transform({2, {FromYaw(M_PI / 2), {0, 0, 5}}}, one);
  EXPECT_EQ(moved.stamps_ns, one.stamps_ns);
  EXPECT_LT((moved.poses[0].t - Eigen::Vector3d(0, 2, 5)).norm(), 1e-12);
  EXPECT_NEAR(Yaw(moved.poses[0].q), 0.5 + M_PI / 2, 1e-12);
  const Trajectory camera = Transform(one, {Eigen::Quaterniond::Identity(), {1, 0, 0}});
  EXPECT_LT((camera.poses[0].t - Eigen::Vector3d(1 + std::cos(0.5), std::sin(0.5), 0)).norm(),
            1e-12);
}

}  // namespace
}  // namespace deja_view
