#pragma once

#include "deja_view/bundle/bundle_problem.hpp"

#include <string>
#include <vector>

namespace deja_view {

/// How far the given poses are believed (standard deviations).
struct BundlePriorOptions {
  // Drift of an odometry between consecutive images, a random walk.
  double odometry_floor_m = 0.001;       ///< [m] per step and axis
  double odometry_per_sqrt_m = 0.01;     ///< [m / sqrt(m)]
  double odometry_floor_deg = 0.02;      ///< [deg] per step and axis
  double odometry_per_sqrt_m_deg = 0.2;  ///< [deg / sqrt(m)]
  double tilt_deg = 0.3;                 ///< an odometry's roll and pitch
  double pose_m = 0.05;                  ///< given poses, per axis
  double pose_deg = 2.0;                 ///< given poses, per axis

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("odometry_floor_m", odometry_floor_m);
    v("odometry_per_sqrt_m", odometry_per_sqrt_m);
    v("odometry_floor_deg", odometry_floor_deg);
    v("odometry_per_sqrt_m_deg", odometry_per_sqrt_m_deg);
    v("tilt_deg", tilt_deg);
    v("pose_m", pose_m);
    v("pose_deg", pose_deg);
  }
};

/// Priors of an odometry: relative poses of consecutive images of one sequence, and each image's
/// roll and pitch. `T_W_B` as the odometry had them, `sequences` their sessions, one per image.
void AddOdometryPriors(const BundlePriorOptions& options,
                       const std::vector<Rigid3>& T_W_B,
                       const std::vector<int>& sequences,
                       BundleProblem* problem);

/// Priors of each image's pose at where it is.
void AddPosePriors(const BundlePriorOptions& options, BundleProblem* problem);

/// Velocities of the images of each sequence from the poses before and after, for time offsets;
/// none where these are more than a second apart.
void SetVelocities(const std::vector<int>& sequences, BundleProblem* problem);

}  // namespace deja_view
