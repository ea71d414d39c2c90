#include "deja_view/geometry/rigid3.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/SVD>

namespace deja_view {

double RotationAngle(const Eigen::Quaterniond& q) {
  return 2.0 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  // sin(a/2)/a by its series where the quotient loses digits.
  const double scale = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = scale * rotation_vector;
  return q.normalized();
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const double norm = q.vec().norm();
  if (norm < 1e-10) {
    return 2.0 * sign * q.vec();
  }
  return (2.0 * sign * std::atan2(norm, std::abs(q.w())) / norm) * q.vec();
}

std::optional<Eigen::Quaterniond> NearestRotation(const Eigen::Matrix3d& matrix, double tolerance) {
  const Eigen::Matrix3d difference = matrix * matrix.transpose() - Eigen::Matrix3d::Identity();
  if (!matrix.allFinite() || !(difference.cwiseAbs().maxCoeff() <= tolerance) ||
      matrix.determinant() < 0) {
    return std::nullopt;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  return Eigen::Quaterniond(nearest).normalized();
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& w) {
  Eigen::Matrix3d S;
  S << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return S;
}

double WrapAngle(double angle) {
  return std::atan2(std::sin(angle), std::cos(angle));
}

double Yaw(const Eigen::Quaterniond& q) {
  return std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()),
                    1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z()));
}

Eigen::Quaterniond FromYaw(double yaw) {
  return {std::cos(0.5 * yaw), 0.0, 0.0, std::sin(0.5 * yaw)};
}

YawTransform ToYawTransform(const Rigid3& T_A_B) {
  // The nearest rotation about z in the Frobenius norm: maximises the trace of Rz^T R.
  const Eigen::Matrix3d R = T_A_B.R();
  return {std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)), T_A_B.t};
}

Rigid3 Interpolate(const Rigid3& from, const Rigid3& to, double u) {
  return {from.q.slerp(u, to.q).normalized(), (1.0 - u) * from.t + u * to.t};
}

}  // namespace deja_view
