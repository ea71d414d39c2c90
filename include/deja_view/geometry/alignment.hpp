#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// x_A = scale * (R_A_B x_B) + t_A_B.
struct Similarity3 {
  double scale = 1.0;
  Rigid3 T_A_B;

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_B) const {
    return T_A_B.q * (scale * p_B) + T_A_B.t;
  }
  Similarity3 Inverse() const {
    const Rigid3 T_B_A = T_A_B.Inverse();
    return {1 / scale, {T_B_A.q, T_B_A.t / scale}};
  }
};

Eigen::Vector3d MeanPoint(const std::vector<Eigen::Vector3d>& points);

/// Least-squares alignment of points, ‖p_A − (s R p_B + t)‖², by Umeyama (PAMI 1991).
/// `with_scale` false keeps s = 1, as `evo_ape -a` does. Throws CheckError for sizes that differ or
/// fewer than 3 points; for points on one line the rotation about it is arbitrary.
Similarity3 AlignPoints(const std::vector<Eigen::Vector3d>& p_A,
                        const std::vector<Eigen::Vector3d>& p_B,
                        bool with_scale = false);

/// The same over yaw and position alone: the yaw that turns the centred, horizontal parts on each
/// other. Throws CheckError for sizes that differ or no points; for one point the yaw is 0.
Rigid3 AlignYaw(const std::vector<Eigen::Vector3d>& p_A, const std::vector<Eigen::Vector3d>& p_B);

}  // namespace deja_view
