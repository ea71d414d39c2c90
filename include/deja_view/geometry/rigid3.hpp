#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace deja_view {

/// Frames used throughout. `p_A = T_A_B * p_B`: inner letters cancel.
///   W  world of one VIO session: metres, z up (gravity aligned), yaw and origin arbitrary
///   M  the map: the world that loop closure corrects into; W of the first session until it drifts
///   B  body = IMU
///   C  camera: x right, y down, z forward
///   V  virtual camera
///   N  the unit cube of the NeRF
/// Time stamps are int64_t nanoseconds.

/// Rigid transform T_A_B: rotation `R_A_B` as a unit quaternion and the origin of B in A, `t_A_B`
/// [m].
struct Rigid3 {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  static Rigid3 Identity() { return {}; }

  Rigid3 Inverse() const {
    const Eigen::Quaterniond inverse = q.conjugate();
    return {inverse, -(inverse * t)};
  }
  Eigen::Matrix3d R() const { return q.toRotationMatrix(); }
  bool IsFinite() const { return q.coeffs().allFinite() && t.allFinite(); }
};

/// T_A_C = T_A_B * T_B_C. The quaternion is normalised again so that long chains stay in SO(3).
inline Rigid3 operator*(const Rigid3& T_A_B, const Rigid3& T_B_C) {
  return {(T_A_B.q * T_B_C.q).normalized(), T_A_B.t + T_A_B.q * T_B_C.t};
}

/// p_A = T_A_B * p_B.
inline Eigen::Vector3d operator*(const Rigid3& T_A_B, const Eigen::Vector3d& p_B) {
  return T_A_B.q * p_B + T_A_B.t;
}

/// Angle of the rotation [rad], in [0, pi].
double RotationAngle(const Eigen::Quaterniond& q);

/// Rotation vector [rad] to quaternion and back (exponential and logarithm of SO(3)).
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector);
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q);

/// The rotation nearest to a matrix (in the Frobenius norm), as read from a rounded file. Nothing
/// for one that is not finite, mirrors, or whose |R R^T - I| has an entry above `tolerance`.
std::optional<Eigen::Quaterniond> NearestRotation(const Eigen::Matrix3d& matrix, double tolerance);

/// The numbers of a pose as files and messages have them.
inline std::array<double, 3> Numbers(const Eigen::Vector3d& t) {
  return {t.x(), t.y(), t.z()};
}
inline std::array<double, 4> ScalarLast(const Eigen::Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}
inline std::array<double, 4> ScalarFirst(const Eigen::Quaterniond& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}

/// Matrix S with S * v = w x v.
Eigen::Matrix3d Skew(const Eigen::Vector3d& w);

/// Wraps an angle [rad] to [-pi, pi].
double WrapAngle(double angle);

/// Yaw of R_A_B about A's z [rad]: the angle psi of the factorisation R = Rz(psi) Ry(theta)
/// Rx(phi).
double Yaw(const Eigen::Quaterniond& q);

/// Rotation by `yaw` [rad] about z.
Eigen::Quaterniond FromYaw(double yaw);

/// Transform with four degrees of freedom: yaw about gravity and translation, what VIO can't
/// observe.
struct YawTransform {
  double yaw = 0.0;                             ///< [rad]
  Eigen::Vector3d t = Eigen::Vector3d::Zero();  ///< [m]

  Rigid3 ToRigid3() const { return {FromYaw(yaw), t}; }
};

/// The 4-DoF transform nearest to T_A_B: keeps its translation and yaw, drops roll and pitch.
YawTransform ToYawTransform(const Rigid3& T_A_B);

/// Interpolates linearly in t and spherically in q; `u` in [0, 1].
Rigid3 Interpolate(const Rigid3& from, const Rigid3& to, double u);

}  // namespace deja_view
