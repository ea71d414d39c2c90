#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// Relative pose of two bodies, O (old) and U (current), from points that one body has located and
/// the other sees. All cameras of a body, real or virtual, form one rigid rig: an observation
/// carries its camera's centre, so that any number of cameras enter one generalised pose problem.
/// Errors are measured on the unit sphere and scaled by the focal length to pixels, whatever the
/// lens.

/// A point located by one body and seen by a camera of the other.
struct PointObservation {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< [m] in the body that located it
  Eigen::Vector3d sight =
      Eigen::Vector3d::UnitZ();  ///< unit, its camera's ray to `point`, same frame
  double depth_sigma = 0.0;      ///< [m] standard deviation of `point` along `sight`
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();  ///< unit, in the observing body's frame
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< [m] observing camera's centre, same frame
  bool is_reverse = false;  ///< false: point in U, seen from O; true: point in O, seen from U
};

/// Solves for Rz(yaw) and t with G_a level and G_b level (z up): two points p_i in G_b, seen from
/// centres c_i in G_a along unit bearings f_i, so that c_i + lambda_i f_i = Rz(yaw) p_i + t with
/// lambda_i > 0. The absolute pose problem with known vertical direction (Kukelova, Bujnak, Pajdla,
/// ACCV 2010), written for the depths: z gives one linear equation in lambda_1, lambda_2, the
/// horizontal distance of the points a quadratic one. Returns 0, 1 or 2 solutions.
struct GravityAlignedPoint {
  Eigen::Vector3d point;
  Eigen::Vector3d bearing;
  Eigen::Vector3d centre;
};
std::vector<YawTransform> SolveTwoPointGravityPose(const GravityAlignedPoint& first,
                                                   const GravityAlignedPoint& second);

struct RelativePoseOptions {
  double inlier_threshold_px = 4.0;  ///< in the final count; along the ray's uncertainty more
  double ransac_threshold_px = 8.0;  ///< for the two-point hypotheses
  double pixel_sigma = 1.0;          ///< [px] of a keypoint
  double tilt_sigma_deg = 0.3;       ///< roll and pitch of VIO, as a prior in the final estimate
  int max_iterations = 300;          ///< of RANSAC
  int max_refinements = 10;          ///< Gauss-Newton steps
  double confidence = 0.999;
  std::uint32_t seed = 1;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("inlier_threshold_px", inlier_threshold_px);
    v("ransac_threshold_px", ransac_threshold_px);
    v("pixel_sigma", pixel_sigma);
    v("tilt_sigma_deg", tilt_sigma_deg);
    v("max_iterations", max_iterations);
    v("max_refinements", max_refinements);
    v("confidence", confidence);
    v("seed", seed);
  }
  std::vector<std::string> Validate() const;
};

/// Level frames of the two bodies: R_G_O and R_G_U without yaw (VIO's roll and pitch).
struct GravityPair {
  Eigen::Quaterniond q_G_O = Eigen::Quaterniond::Identity();
  Eigen::Quaterniond q_G_U = Eigen::Quaterniond::Identity();
};

/// The smallest rotation q_G_B that makes the body level: G's z is the world's. Unlike Euler angles
/// it is smooth for a body whose x axis points up, as EuRoC's IMU does.
Eigen::Quaterniond LevelRotation(const Eigen::Quaterniond& q_W_B);

/// RANSAC over two-point hypotheses. Returns T_O_U and its inliers' indices in order; no inliers
/// when nothing better than two points was found. `focal_px` turns radians into pixels.
/// Deterministic.
///
/// Why not OpenGV's generalised P3P (Kneip and Furgale, ICRA 2014), which needs no vertical: on 100
/// matches of rigs of 2 to 5 cameras within 0.02 to 0.8 m, 0.5 to 2 px of noise, and 0.2 degrees
/// of error in VIO's tilt, this takes 14 to 60 us for 20 to 70 % of outliers, OpenGV's RANSAC 0.24
/// to 18 ms, for three points must be right at once; its hypotheses are no better (4 and 7 cm
/// against 5 and 8 cm at 0.5 and 2 px), and after RefineRelativePose both end at the same pose.
/// Nor does it take matches of both directions in one problem. It is better where the tilt is off
/// by a degree (99 % of scenes solved against 85 %) or two (67 % against 40 %), which is far from
/// what VIO's is (tilt_sigma_deg). Its linear solver for all inliers (gpnp) is less exact than the
/// refinement. Figures: rig_pose_benchmark; opengv_test compares the two where OpenGV is installed.
struct RansacResult {
  Rigid3 T_O_U;
  std::vector<int> inliers;
};
RansacResult EstimateRelativePose(const std::vector<PointObservation>& observations,
                                  const GravityPair& gravity,
                                  double focal_px,
                                  const RelativePoseOptions& options);

/// Result of RefineRelativePose.
struct RefinedPose {
  Rigid3 T_O_U;
  /// Of (t_O_U [m], rotation vector w [rad]) with T_O_U = (t + dt, Exp(w) R): in frame O.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double rmse_px = 0;        ///< of the inliers, whitened back to pixels
  std::vector<int> inliers;  ///< observations within the inlier threshold at the solution
};

/// Robust (Cauchy) non-linear least squares over all six degrees of freedom, each residual whitened
/// with the pixel noise and the depth noise of its point. With `use_gravity`, VIO's roll and pitch
/// enter as a prior; without, the result can be tested against them. The covariance is (J^T W J)^-1
/// times the inliers' variance factor, at least 1.
RefinedPose RefineRelativePose(const Rigid3& T_O_U_initial,
                               const std::vector<PointObservation>& observations,
                               const GravityPair& gravity,
                               bool use_gravity,
                               double focal_px,
                               const RelativePoseOptions& options);

/// Angle [rad] between the two directions of gravity that T_O_U and the VIO's tilt imply.
double GravityDisagreement(const Rigid3& T_O_U, const GravityPair& gravity);

}  // namespace deja_view
