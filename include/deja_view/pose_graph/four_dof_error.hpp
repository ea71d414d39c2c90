#pragma once

#include <memory>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <ceres/sized_cost_function.h>

namespace deja_view {

/// 4-DoF relative pose error between the body frames I and J of two keyframes.
///
/// Roll and pitch are observable in VIO and stay fixed; only position and yaw move (Qin, Li, Shen,
/// VINS-Mono, T-RO 2018, global pose graph). A keyframe's state is its correction angle `psi` about
/// the map's z axis and its position: R_M_I = Rz(psi_i) R_W_I with the VIO's R_W_I. Unlike the yaw
/// of Euler angles, psi has no singularity for a body whose x axis points up.
///
///   e[0:3] = R_W_I^T Rz(psi_i)^T (t_M_J - t_M_I) - t_I_J      in frame I [m]
///   e[3]   = wrap(psi_j - psi_i - delta_psi)                   [rad]
///   r      = weight * L e,   L^T L the information
///
/// Parameter blocks: psi_i (1) [rad], t_M_I (3) [m], psi_j (1) [rad], t_M_J (3) [m].
class FourDofError : public ceres::SizedCostFunction<4, 1, 3, 1, 3> {
 public:
  struct Measurement {
    Eigen::Vector3d t_I_J = Eigen::Vector3d::Zero();      ///< [m] origin of J, in frame I
    double delta_psi = 0.0;                               ///< [rad] psi_j - psi_i
    Eigen::Matrix3d R_W_I = Eigen::Matrix3d::Identity();  ///< as received from the VIO
    Eigen::Matrix4d sqrt_information = Eigen::Matrix4d::Identity();  ///< L, of (t [m], psi [rad])
  };

  /// `weight` scales the residual (the robust kernel's square root of a line process in [0, 1]).
  explicit FourDofError(const Measurement& measurement, double weight = 1.0);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  Measurement measurement_;
  Eigen::Matrix4d weighted_sqrt_information_;
};

/// delta_psi of a measured relative rotation: the z rotation nearest to R_W_I R_I_J R_W_J^T.
double DeltaPsi(const Eigen::Quaterniond& q_W_I,
                const Eigen::Quaterniond& q_I_J,
                const Eigen::Quaterniond& q_W_J);

}  // namespace deja_view
