#include "prior_errors.hpp"

#include "deja_view/geometry/rigid3.hpp"

#include <memory>

#include "jacobian_check.hpp"

namespace deja_view::internal {
namespace {

const Rigid3 kFrom{ExpSo3({0.3, -0.2, 1.1}), {1, 2, 3}};
const Rigid3 kTo{ExpSo3({0.1, 0.4, 1.3}), {1.5, 2.2, 2.7}};

Eigen::VectorXd Block(const Eigen::Vector3d& w, const Eigen::Vector3d& t) {
  Eigen::VectorXd block(6);
  block << w, t;
  return block;
}

TEST(RelativePoseError, IsZeroAtTheMeasurementAndCountsInSigmas) {
  const RelativePosePrior prior{0, 1, kFrom.Inverse() * kTo, 0.01, 0.002};
  const std::unique_ptr<ceres::CostFunction> cost(
      RelativePoseError::Create({prior, kFrom.q, kTo.q}));
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  EXPECT_LT(test::Residuals(*cost, {Block(zero, kFrom.t), Block(zero, kTo.t)}).norm(), 1e-12);
  const Eigen::Vector3d shift(0.02, 0, 0);
  const Eigen::Vector3d turn(0, 0, 0.004);
  const Eigen::VectorXd r =
      test::Residuals(*cost, {Block(zero, kFrom.t), Block(turn, kTo.t + shift)});
  EXPECT_NEAR(r.head<3>().norm(), 2, 1e-9);
  EXPECT_NEAR(r.tail<3>().norm(), 2, 1e-5);
}

TEST(RelativePoseError, JacobiansMatchDifferences) {
  const RelativePosePrior prior{0, 1, kFrom.Inverse() * kTo, 0.01, 0.002};
  const std::unique_ptr<ceres::CostFunction> cost(
      RelativePoseError::Create({prior, kFrom.q, kTo.q}));
  test::ExpectJacobiansMatch(
      *cost,
      {Block({0.03, -0.02, 0.05}, {1.1, 2, 2.9}), Block({-0.04, 0.01, 0.02}, {1.4, 2.1, 2.8})},
      1e-6);
}

TEST(TiltError, SeesRollAndPitchButNotYaw) {
  const TiltPrior prior{0, kFrom.q.conjugate() * Eigen::Vector3d::UnitZ(), 0.01};
  const std::unique_ptr<ceres::CostFunction> cost(TiltError::Create({prior, kFrom.q}));
  EXPECT_LT(test::Residuals(*cost, {Block({0, 0, 0.7}, {5, 6, 7})}).norm(), 1e-9);
  EXPECT_NEAR(test::Residuals(*cost, {Block({0.02, 0, 0}, {5, 6, 7})}).norm(), 2, 1e-3);
  test::ExpectJacobiansMatch(*cost, {Block({0.03, -0.02, 0.05}, {1, 2, 3})}, 1e-6);
}

TEST(PoseError, IsZeroAtThePriorWithMatchingJacobians) {
  const PosePrior prior{0, kFrom, 0.05, 0.02};
  const std::unique_ptr<ceres::CostFunction> cost(PoseError::Create({prior, kFrom.q}));
  EXPECT_LT(test::Residuals(*cost, {Block(Eigen::Vector3d::Zero(), kFrom.t)}).norm(), 1e-12);
  test::ExpectJacobiansMatch(*cost, {Block({0.03, -0.02, 0.05}, {1.2, 2, 3})}, 1e-6);
}

}  // namespace
}  // namespace deja_view::internal
