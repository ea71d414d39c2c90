#include "deja_view/verification/relative_pose.hpp"

#include "deja_view/base/angles.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr double kFocal = 460.0;

/// Two bodies with one camera each in a room of random points; O and U both locate points and see
/// the other's.
struct Scene {
  Rigid3 T_W_O;
  Rigid3 T_W_U;
  Rigid3 T_B_C{ExpSo3({0.1, 1.5, -0.2}), {0.05, -0.06, 0.01}};
  GravityPair gravity;
  std::vector<PointObservation> observations;
  int outliers = 0;

  Rigid3 T_O_U() const { return T_W_O.Inverse() * T_W_U; }
};

struct SceneOptions {
  int forward = 80;
  int reverse = 0;
  double pixel_noise = 0.5;
  double depth_noise = 0.0;
  double outlier_ratio = 0.0;
  std::uint32_t seed = 1;
};

Scene MakeScene(const SceneOptions& options) {
  std::mt19937 rng(options.seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  const auto random = [&](double range) {
    return Eigen::Vector3d(range * uniform(rng), range * uniform(rng), range * uniform(rng));
  };
  Scene scene;
  scene.T_W_O = {ExpSo3({0.1, -0.2, 0.5}), {1, 2, 1}};
  scene.T_W_U = {ExpSo3({-0.15, 0.1, 0.9}), {1.6, 1.7, 1.3}};
  scene.gravity = {LevelRotation(scene.T_W_O.q), LevelRotation(scene.T_W_U.q)};
  const auto add = [&](bool is_reverse) {
    const Rigid3& T_W_located = is_reverse ? scene.T_W_O : scene.T_W_U;
    const Rigid3& T_W_seeing = is_reverse ? scene.T_W_U : scene.T_W_O;
    const Eigen::Vector3d p_C(2.0 * uniform(rng), 1.5 * uniform(rng), 4.0 + 2.0 * uniform(rng));
    PointObservation o;
    o.is_reverse = is_reverse;
    o.centre = scene.T_B_C.t;
    o.sight = scene.T_B_C.q * p_C.normalized();
    o.depth_sigma = std::max(0.01, options.depth_noise) * p_C.norm();
    const Eigen::Vector3d truth = scene.T_B_C * p_C;
    o.point = truth + o.sight * (options.depth_noise * p_C.norm() * normal(rng));
    const Eigen::Vector3d seen = T_W_seeing.Inverse() * (T_W_located * truth) - o.centre;
    o.bearing = (seen.normalized() + options.pixel_noise / kFocal *
                                         Eigen::Vector3d(normal(rng), normal(rng), normal(rng)))
                    .normalized();
    if (0.5 + 0.5 * uniform(rng) < options.outlier_ratio) {
      o.bearing = (o.bearing + random(0.7)).normalized();
      ++scene.outliers;
    }
    scene.observations.push_back(o);
  };
  for (int i = 0; i < options.forward; ++i) {
    add(false);
  }
  for (int i = 0; i < options.reverse; ++i) {
    add(true);
  }
  return scene;
}

double TranslationError(const Rigid3& T, const Scene& scene) {
  return (T.t - scene.T_O_U().t).norm();
}
double RotationError(const Rigid3& T, const Scene& scene) {
  return RotationAngle(T.q.conjugate() * scene.T_O_U().q);
}

TEST(LevelRotation, MakesGravityTheZAxis) {
  for (const Eigen::Vector3d& w :
       {Eigen::Vector3d(0.1, 0.2, 2.0), Eigen::Vector3d(0.0, -1.5707963, 0.3)}) {
    const Eigen::Quaterniond q_W_B = ExpSo3(w);
    const Eigen::Quaterniond q_G_B = LevelRotation(q_W_B);
    const Eigen::Vector3d up_B = q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    EXPECT_LT((q_G_B * up_B - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  }
}

TEST(EstimateRelativePose, SurvivesSeventyPercentOutliers) {
  for (std::uint32_t seed = 1; seed < 6; ++seed) {
    SceneOptions options;
    options.outlier_ratio = 0.7;
    options.seed = seed;
    const Scene scene = MakeScene(options);
    const auto result = EstimateRelativePose(scene.observations, scene.gravity, kFocal, {});
    EXPECT_GE(result.inliers.size(), 0.8 * (80 - scene.outliers));
    EXPECT_LT(TranslationError(result.T_O_U, scene), 0.15);
  }
}

TEST(EstimateRelativePose, FindsNothingInNoise) {
  SceneOptions options;
  options.outlier_ratio = 1.0;
  const Scene scene = MakeScene(options);
  const auto result = EstimateRelativePose(scene.observations, scene.gravity, kFocal, {});
  EXPECT_LT(result.inliers.size(), 12U);
}

TEST(EstimateRelativePose, IsDeterministic) {
  SceneOptions options;
  options.outlier_ratio = 0.5;
  const Scene scene = MakeScene(options);
  const auto a = EstimateRelativePose(scene.observations, scene.gravity, kFocal, {});
  const auto b = EstimateRelativePose(scene.observations, scene.gravity, kFocal, {});
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.T_O_U.t, b.T_O_U.t);
}

TEST(EstimateRelativePose, SolvesFromReverseObservationsAlone) {
  SceneOptions options;
  options.forward = 0;
  options.reverse = 60;
  options.outlier_ratio = 0.4;
  const Scene scene = MakeScene(options);
  const auto result = EstimateRelativePose(scene.observations, scene.gravity, kFocal, {});
  EXPECT_LT(TranslationError(result.T_O_U, scene), 0.15);
}

TEST(RefineRelativePose, IsExactWithoutNoise) {
  SceneOptions options;
  options.pixel_noise = 0;
  options.reverse = 40;
  const Scene scene = MakeScene(options);
  const Rigid3 start{ExpSo3({0.02, -0.03, 0.05}) * scene.T_O_U().q,
                     scene.T_O_U().t + Eigen::Vector3d(0.1, -0.1, 0.05)};
  for (const bool use_gravity : {false, true}) {
    const auto refined =
        RefineRelativePose(start, scene.observations, scene.gravity, use_gravity, kFocal, {});
    EXPECT_LT(TranslationError(refined.T_O_U, scene), 1e-5);
    EXPECT_LT(RotationError(refined.T_O_U, scene), 1e-6);
    EXPECT_EQ(refined.inliers.size(), scene.observations.size());
  }
}

TEST(RefineRelativePose, IgnoresOutliers) {
  SceneOptions options;
  options.outlier_ratio = 0.3;
  options.depth_noise = 0.02;
  const Scene scene = MakeScene(options);
  const auto refined =
      RefineRelativePose(scene.T_O_U(), scene.observations, scene.gravity, true, kFocal, {});
  EXPECT_LT(TranslationError(refined.T_O_U, scene), 0.03);
  EXPECT_LT(RotationError(refined.T_O_U, scene), 0.3 * kDegree);
  EXPECT_NEAR(static_cast<double>(refined.inliers.size()), 80 - scene.outliers, 6);
}

TEST(RefineRelativePose, CovarianceMatchesTheErrorsOfManyRuns) {
  double normalised = 0;
  constexpr int kRuns = 100;
  for (int run = 0; run < kRuns; ++run) {
    SceneOptions options;
    options.seed = 100 + static_cast<std::uint32_t>(run);
    options.reverse = 40;
    options.pixel_noise = 1.0;
    options.depth_noise = 0.03;
    const Scene scene = MakeScene(options);
    const auto refined =
        RefineRelativePose(scene.T_O_U(), scene.observations, scene.gravity, false, kFocal, {});
    const Eigen::Vector3d error = refined.T_O_U.t - scene.T_O_U().t;
    normalised += error.dot(refined.covariance.topLeftCorner<3, 3>().ldlt().solve(error));
  }
  // Chi-squared with three degrees of freedom, a robust kernel that widens it a little, and a
  // variance factor of at least 1.
  EXPECT_GT(normalised / kRuns, 1.5);
  EXPECT_LT(normalised / kRuns, 4.0);
}

TEST(GravityDisagreement, IsTheTiltBetweenTheTwoVerticals) {
  const Scene scene = MakeScene({});
  EXPECT_LT(GravityDisagreement(scene.T_O_U(), scene.gravity), 1e-9);
  Rigid3 tilted = scene.T_O_U();
  const Eigen::Vector3d up_O = scene.gravity.q_G_O.conjugate() * Eigen::Vector3d::UnitZ();
  tilted.q = ExpSo3(5.0 * kDegree * up_O.unitOrthogonal()) * tilted.q;
  EXPECT_NEAR(GravityDisagreement(tilted, scene.gravity), 5.0 * kDegree, 1e-9);
  Rigid3 turned = scene.T_O_U();
  turned.q = ExpSo3(30.0 * kDegree * up_O) * turned.q;
  EXPECT_LT(GravityDisagreement(turned, scene.gravity), 1e-9);
}

}  // namespace
}  // namespace deja_view
