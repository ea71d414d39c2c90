#include "deja_view/verification/relative_pose.hpp"

#include <cmath>

namespace deja_view {
namespace {

/// The yaw and translation that depths lambda along the two bearings imply.
YawTransform FromDepths(const GravityAlignedPoint& a,
                        const GravityAlignedPoint& b,
                        double lambda_a,
                        double lambda_b) {
  const Eigen::Vector3d x_a = a.centre + lambda_a * a.bearing;
  const Eigen::Vector3d x_b = b.centre + lambda_b * b.bearing;
  const Eigen::Vector3d seen = x_a - x_b;
  const Eigen::Vector3d known = a.point - b.point;
  YawTransform result;
  result.yaw = WrapAngle(std::atan2(seen.y(), seen.x()) - std::atan2(known.y(), known.x()));
  const Eigen::Matrix3d R = result.ToRigid3().R();
  result.t = 0.5 * (x_a - R * a.point + x_b - R * b.point);
  return result;
}

}  // namespace

std::vector<YawTransform> SolveTwoPointGravityPose(const GravityAlignedPoint& first,
                                                   const GravityAlignedPoint& second) {
  // Eliminate the depth whose bearing is steeper: its coefficient in the z equation is the larger
  // one.
  const bool swap = std::abs(second.bearing.z()) > std::abs(first.bearing.z());
  const GravityAlignedPoint& a = swap ? second : first;
  const GravityAlignedPoint& b = swap ? first : second;
  constexpr double kLevel = 1e-6;
  if (std::abs(a.bearing.z()) < kLevel) {
    return {};
  }
  // z: lambda_a f_az = h + lambda_b f_bz.  So lambda_a = m + n lambda_b.
  const double h = (a.point - b.point).z() - (a.centre - b.centre).z();
  const double m = h / a.bearing.z();
  const double n = b.bearing.z() / a.bearing.z();
  // Horizontal distance: | u + lambda_b w |^2 = d^2.
  const Eigen::Vector2d u = (a.centre - b.centre + m * a.bearing).head<2>();
  const Eigen::Vector2d w = (n * a.bearing - b.bearing).head<2>();
  const double d2 = (a.point - b.point).head<2>().squaredNorm();
  const double qa = w.squaredNorm();
  const double qb = u.dot(w);
  const double qc = u.squaredNorm() - d2;
  const double discriminant = qb * qb - qa * qc;
  if (qa < kLevel * kLevel || discriminant < 0) {
    return {};
  }
  std::vector<YawTransform> solutions;
  const double root = std::sqrt(discriminant);
  for (const double sign : {-1.0, 1.0}) {
    const double lambda_b = (-qb + sign * root) / qa;
    const double lambda_a = m + n * lambda_b;
    if (lambda_a > 0 && lambda_b > 0) {
      solutions.push_back(FromDepths(a, b, lambda_a, lambda_b));
    }
  }
  return solutions;
}

}  // namespace deja_view
