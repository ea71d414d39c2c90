#include "deja_view/pose_graph/four_dof_error.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

struct EdgeState {
  double psi_i = 0;
  Eigen::Vector3d t_i = Eigen::Vector3d::Zero();
  double psi_j = 0;
  Eigen::Vector3d t_j = Eigen::Vector3d::Zero();

  std::array<const double*, 4> Blocks() const { return {&psi_i, t_i.data(), &psi_j, t_j.data()}; }
};

Eigen::Vector4d Evaluate(const FourDofError& cost, const EdgeState& state) {
  // NaN so that a residual left unwritten fails the test.
  Eigen::Vector4d residuals = Eigen::Vector4d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(cost.Evaluate(state.Blocks().data(), residuals.data(), nullptr));
  return residuals;
}

TEST(FourDofError, IsZeroAtTheMeasurement) {
  FourDofError::Measurement measurement;
  measurement.t_I_J = {1.0, 0.0, 0.0};
  measurement.delta_psi = kPi / 2;
  // I looks along the map's +y, so 1 m ahead of I is +y of the map.
  const EdgeState state{kPi / 2, {2.0, 3.0, 4.0}, kPi, {2.0, 4.0, 4.0}};
  EXPECT_LT(Evaluate(FourDofError(measurement), state).norm(), 1e-12);
}

TEST(FourDofError, WrapsYawAcrossTheCut) {
  FourDofError::Measurement measurement;
  measurement.delta_psi = 0.2;
  const EdgeState state{kPi - 0.1, {0, 0, 0}, -kPi + 0.1, {0, 0, 0}};
  EXPECT_NEAR(Evaluate(FourDofError(measurement), state)[3], 0.0, 1e-12);
}

TEST(FourDofError, JacobiansMatchDifferences) {
  FourDofError::Measurement measurement;
  measurement.t_I_J = {0.5, -0.2, 0.1};
  measurement.delta_psi = 0.3;
  measurement.R_W_I = ExpSo3({0.3, -1.4, 0.5}).toRotationMatrix();
  measurement.sqrt_information << 10, 1, 2, 3, 0, 20, 1, -2, 0, 0, 30, 4, 0, 0, 0, 50;
  const FourDofError cost(measurement, 0.7);
  const EdgeState state{0.4, {1, 2, 3}, -0.2, {1.5, 1.0, 3.3}};

  std::array<double, 4> psi_i{};
  std::array<double, 12> t_i{};
  std::array<double, 4> psi_j{};
  std::array<double, 12> t_j{};
  std::array<double*, 4> jacobians = {psi_i.data(), t_i.data(), psi_j.data(), t_j.data()};
  Eigen::Vector4d residuals;
  ASSERT_TRUE(cost.Evaluate(state.Blocks().data(), residuals.data(), jacobians.data()));

  constexpr double kStep = 1e-6;
  const auto check = [&](auto&& perturb, double* jacobian, int columns, int column) {
    EdgeState plus = state;
    EdgeState minus = state;
    perturb(plus, kStep);
    perturb(minus, -kStep);
    const Eigen::Vector4d numeric = (Evaluate(cost, plus) - Evaluate(cost, minus)) / (2.0 * kStep);
    for (int row = 0; row < 4; ++row) {
      EXPECT_NEAR(jacobian[row * columns + column], numeric[row], 1e-6) << row << "," << column;
    }
  };
  check([](EdgeState& s, double h) { s.psi_i += h; }, psi_i.data(), 1, 0);
  check([](EdgeState& s, double h) { s.psi_j += h; }, psi_j.data(), 1, 0);
  for (int k = 0; k < 3; ++k) {
    check([k](EdgeState& s, double h) { s.t_i[k] += h; }, t_i.data(), 3, k);
    check([k](EdgeState& s, double h) { s.t_j[k] += h; }, t_j.data(), 3, k);
  }
}

TEST(DeltaPsi, TurnsAMeasuredRotationIntoACorrection) {
  // The map's J is turned by 0.25 rad against where the VIO has it, whatever roll and pitch are.
  const Eigen::Quaterniond q_W_I = ExpSo3({0.2, -1.5, 0.4});
  const Eigen::Quaterniond q_W_J = ExpSo3({-0.1, -1.4, 1.4});
  const Eigen::Quaterniond q_M_J = FromYaw(0.25) * q_W_J;
  EXPECT_NEAR(DeltaPsi(q_W_I, q_W_I.conjugate() * q_M_J, q_W_J), 0.25, 1e-12);
}

}  // namespace
}  // namespace deja_view
