#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <gtest/gtest.h>

namespace deja_view::test {

using JacobianBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Residuals of a cost at `blocks`; what it leaves unwritten is NaN.
inline Eigen::VectorXd Residuals(const ceres::CostFunction& cost,
                                 const std::vector<Eigen::VectorXd>& blocks) {
  std::vector<const double*> parameters;
  for (const Eigen::VectorXd& block : blocks) {
    parameters.push_back(block.data());
  }
  Eigen::VectorXd residuals =
      Eigen::VectorXd::Constant(cost.num_residuals(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), nullptr));
  return residuals;
}

/// Compares every Jacobian of a cost at `blocks` with central differences, entry by entry, to
/// within `tolerance` of 1 or of the entry where that is more.
inline void ExpectJacobiansMatch(const ceres::CostFunction& cost,
                                 const std::vector<Eigen::VectorXd>& blocks,
                                 double tolerance) {
  std::vector<const double*> parameters;
  std::vector<JacobianBlock> jacobians;
  for (const Eigen::VectorXd& block : blocks) {
    parameters.push_back(block.data());
    jacobians.push_back(JacobianBlock::Constant(
        cost.num_residuals(), block.size(), std::numeric_limits<double>::quiet_NaN()));
  }
  std::vector<double*> pointers;
  for (JacobianBlock& jacobian : jacobians) {
    pointers.push_back(jacobian.data());
  }
  Eigen::VectorXd residuals(cost.num_residuals());
  ASSERT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), pointers.data()));
  EXPECT_TRUE(residuals.isApprox(Residuals(cost, blocks), 1e-12));
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (Eigen::Index k = 0; k < blocks[b].size(); ++k) {
      const double step = 1e-6 * std::max(1.0, std::abs(blocks[b][k]));
      std::vector<Eigen::VectorXd> plus = blocks;
      std::vector<Eigen::VectorXd> minus = blocks;
      plus[b][k] += step;
      minus[b][k] -= step;
      const Eigen::VectorXd numeric = (Residuals(cost, plus) - Residuals(cost, minus)) / (2 * step);
      for (Eigen::Index r = 0; r < numeric.size(); ++r) {
        EXPECT_NEAR(jacobians[b](r, k), numeric[r], tolerance * std::max(1.0, std::abs(numeric[r])))
            << "block " << b << ", parameter " << k << ", residual " << r;
      }
    }
  }
}

}  // namespace deja_view::test
