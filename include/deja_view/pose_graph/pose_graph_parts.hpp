#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

struct PoseGraphOptions {
  // VIO's drift as a random walk between consecutive keyframes.
  double odometry_sigma_floor_m = 0.001;           ///< [m] per step
  double odometry_sigma_per_sqrt_m = 0.018;        ///< [m / sqrt(m)]
  double odometry_yaw_sigma_floor_deg = 0.005;     ///< [deg] per step
  double odometry_yaw_sigma_per_sqrt_m_deg = 0.2;  ///< [deg / sqrt(m)]
  // What a loop's own covariance does not know: common errors of the points (scale, window drift).
  double loop_sigma_floor_m = 0.01;  ///< [m] per axis
  double loop_sigma_per_m = 0.005;   ///< [m/m] more per metre between the two bodies
  double loop_scale_sigma = 0.05;    ///< of the distance: the scale of the VIO's points wavers
  double loop_yaw_sigma_floor_deg = 0.15;  ///< [deg]
  double kernel_scale = 3.0;               ///< [sigma] of the Geman-McClure kernel on loops
  double kernel_graduation = 2.0;          ///< factor by which the kernel narrows per round, > 1
  int max_iterations = 10;                 ///< of the solver, per round
  /// Newest keyframes that are nodes whatever they see; older ones that are no places are dropped.
  /// 0: none is.
  int window = 300;
  // A loop that the graph contradicts is withdrawn. 0.005 is the kernel's weight of a loop that is
  // off by 11 sigma. Of right ones three in a million are off by 5.6 if all errors were noise; in a
  // room one in ten is, as lens and depths are a little off together.
  double withdraw_weight = 0.005;  ///< with a smaller weight
  int withdraw_after = 2;          ///< in so many solutions one after the other

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("odometry_sigma_floor_m", odometry_sigma_floor_m);
    v("odometry_sigma_per_sqrt_m", odometry_sigma_per_sqrt_m);
    v("odometry_yaw_sigma_floor_deg", odometry_yaw_sigma_floor_deg);
    v("odometry_yaw_sigma_per_sqrt_m_deg", odometry_yaw_sigma_per_sqrt_m_deg);
    v("loop_sigma_floor_m", loop_sigma_floor_m);
    v("loop_sigma_per_m", loop_sigma_per_m);
    v("loop_scale_sigma", loop_scale_sigma);
    v("loop_yaw_sigma_floor_deg", loop_yaw_sigma_floor_deg);
    v("kernel_scale", kernel_scale);
    v("kernel_graduation", kernel_graduation);
    v("max_iterations", max_iterations);
    v("window", window);
    v("withdraw_weight", withdraw_weight);
    v("withdraw_after", withdraw_after);
  }
  std::vector<std::string> Validate() const;
};

/// A keyframe of the graph.
struct PoseGraphNode {
  int sequence = 0;
  bool is_fixed = false;  ///< part of a loaded map: never moves
  Rigid3 T_W_B;           ///< as received from the VIO
  double psi = 0;         ///< [rad] correction about the map's z: R_M_B = Rz(psi) R_W_B
  Eigen::Vector3d t_M_B = Eigen::Vector3d::Zero();  ///< [m]

  Rigid3 T_M_B() const { return {(FromYaw(psi) * T_W_B.q).normalized(), t_M_B}; }
};

/// A loop constraint between two nodes, `from` the older one.
struct PoseGraphLoop {
  int from = -1;
  int to = -1;
  Rigid3 T_from_to;  ///< measured [m]
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Identity();  ///< of (t, rotation vector) in frame `from`
  double scene_depth = 5.0;  ///< [m] median distance of the points it rests on: the scene's scale
  double weight = 1.0;       ///< line process of the robust kernel after the last solve, in [0, 1]
  int contradicted = 0;      ///< solutions in a row, the last one among them, that switched it off
};

/// What two nodes know of each other beside loops, and no kernel doubts: odometry, and what dropped
/// nodes knew.
struct PoseGraphTie {
  int from = -1;
  int to = -1;                                      ///< the younger
  Eigen::Vector3d t_I_J = Eigen::Vector3d::Zero();  ///< [m] origin of `to`, in frame `from`
  double delta_psi = 0;                             ///< [rad] psi of `to` less that of `from`
  Eigen::Matrix4d information = Eigen::Matrix4d::Identity();  ///< of (t [m], psi [rad])
};

}  // namespace deja_view
