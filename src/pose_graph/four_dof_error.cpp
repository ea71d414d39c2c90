#include "deja_view/pose_graph/four_dof_error.hpp"

#include "deja_view/geometry/rigid3.hpp"

#include <cmath>

namespace deja_view {

FourDofError::FourDofError(const Measurement& measurement, double weight)
    : measurement_(measurement),
      weighted_sqrt_information_(weight * measurement.sqrt_information) {}

bool FourDofError::Evaluate(double const* const* parameters,
                            double* residuals,
                            double** jacobians) const {
  const double psi_i = *parameters[0];
  const Eigen::Map<const Eigen::Vector3d> t_M_I(parameters[1]);
  const double psi_j = *parameters[2];
  const Eigen::Map<const Eigen::Vector3d> t_M_J(parameters[3]);
  const double c = std::cos(psi_i);
  const double s = std::sin(psi_i);
  Eigen::Matrix3d Rz_transposed;
  Rz_transposed << c, s, 0, -s, c, 0, 0, 0, 1;
  const Eigen::Matrix3d R_I_M = measurement_.R_W_I.transpose() * Rz_transposed;
  const Eigen::Vector3d d = t_M_J - t_M_I;

  Eigen::Vector4d e;
  e.head<3>() = R_I_M * d - measurement_.t_I_J;
  e[3] = WrapAngle(psi_j - psi_i - measurement_.delta_psi);
  const Eigen::Matrix4d& L = weighted_sqrt_information_;
  Eigen::Map<Eigen::Vector4d>{residuals} = L * e;
  if (jacobians == nullptr) {
    return true;
  }

  using Jacobian43 = Eigen::Matrix<double, 4, 3, Eigen::RowMajor>;
  if (jacobians[0] != nullptr) {
    // d(Rz^T d)/d psi = (-s dx + c dy, -c dx - s dy, 0)
    const Eigen::Vector3d turned(-s * d.x() + c * d.y(), -c * d.x() - s * d.y(), 0.0);
    Eigen::Vector4d de;
    de.head<3>() = measurement_.R_W_I.transpose() * turned;
    de[3] = -1.0;
    Eigen::Map<Eigen::Vector4d>{jacobians[0]} = L * de;
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<Jacobian43>{jacobians[1]} = -L.leftCols<3>() * R_I_M;
  }
  if (jacobians[2] != nullptr) {
    Eigen::Map<Eigen::Vector4d>{jacobians[2]} = L.col(3);
  }
  if (jacobians[3] != nullptr) {
    Eigen::Map<Jacobian43>{jacobians[3]} = L.leftCols<3>() * R_I_M;
  }
  return true;
}

double DeltaPsi(const Eigen::Quaterniond& q_W_I,
                const Eigen::Quaterniond& q_I_J,
                const Eigen::Quaterniond& q_W_J) {
  // R_M_J = R_M_I R_I_J: Rz(psi_j) R_W_J = Rz(psi_i) R_W_I R_I_J.
  return ToYawTransform({q_W_I * q_I_J * q_W_J.conjugate(), Eigen::Vector3d::Zero()}).yaw;
}

}  // namespace deja_view
