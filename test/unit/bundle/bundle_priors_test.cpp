#include "deja_view/bundle/bundle_priors.hpp"

#include "bundle_scene.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

TEST(BundlePriors, DefaultsAreValidAndZeroSigmasAreNot) {
  BundlePriorOptions options;
  EXPECT_THAT(options.Validate(), ::testing::IsEmpty());
  options.tilt_deg = 0;
  EXPECT_THAT(options.Validate(), ::testing::ElementsAre(::testing::HasSubstr("tilt_deg")));
}

TEST(BundlePriors, OdometryConnectsTheImagesOfASequence) {
  test::BundleScene scene = test::MakeBundleScene(test::SceneOf(4, 1));
  BundlePriorOptions options;
  AddOdometryPriors(options, scene.T_vio, {0, 0, 1, 1}, &scene.problem);
  ASSERT_EQ(scene.problem.relative_priors.size(), 2U);
  const RelativePosePrior& prior = scene.problem.relative_priors[1];
  EXPECT_EQ(prior.from, 2);
  EXPECT_EQ(prior.to, 3);
  const Rigid3 T = scene.T_vio[2].Inverse() * scene.T_vio[3];
  EXPECT_LT((prior.T_from_to.t - T.t).norm(), 1e-12);
  EXPECT_NEAR(prior.sigma_m, std::sqrt(1e-6 + 1e-4 * T.t.norm()), 1e-12);
  ASSERT_EQ(scene.problem.tilt_priors.size(), 4U);
  const Eigen::Vector3d up = scene.T_vio[3].q * scene.problem.tilt_priors[3].up_B;
  EXPECT_LT((up - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(BundlePriors, VelocitiesAreThoseOfThePosesAround) {
  BundleProblem problem;
  const Eigen::Vector3d v(1, -2, 0.5);
  const Eigen::Vector3d omega_B(0.2, 0.1, -0.3);
  for (int i = 0; i < 5; ++i) {
    const double t = 0.1 * i + (i == 4 ? 2 : 0);  // a pause before the last
    BundleImage& image = problem.images.emplace_back();
    image.stamp_ns = std::llround(1e9 * t);
    image.T_W_B = {ExpSo3({0.3, 0, 0.4}) * ExpSo3(t * omega_B), t * v};
  }
  SetVelocities({0, 0, 0, 0, 0}, &problem);
  for (const std::size_t i : {0, 1, 2}) {
    EXPECT_LT((problem.images[i].velocity_W - v).norm(), 1e-9) << i;
    EXPECT_LT((problem.images[i].angular_velocity_B - omega_B).norm(), 1e-6) << i;
  }
  EXPECT_EQ(problem.images[4].velocity_W.norm(), 0);
}

}  // namespace
}  // namespace deja_view
