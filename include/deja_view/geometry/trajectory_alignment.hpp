#pragma once

#include "deja_view/geometry/alignment.hpp"
#include "deja_view/geometry/trajectory.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// What may differ between two worlds.
enum class AlignmentFreedom {
  kYaw,         ///< yaw about z and position: both know gravity, as two runs of a VIO do
  kRigid,       ///< rotation and position
  kSimilarity,  ///< rotation, position and scale: structure from motion
};

struct AlignmentOptions {
  AlignmentFreedom freedom = AlignmentFreedom::kRigid;
  double inlier_distance_m = 0.3;         ///< farther pairs are outliers; in the world aligned to
  double max_rmse_m = 0.2;                ///< of the inliers
  double min_inlier_share = 0.5;          ///< of the pairs
  double max_rotation_rad = 0.35;         ///< median difference of orientation after alignment
  std::int64_t max_gap_ns = 500'000'000;  ///< poses are interpolated over no more than this
  std::uint64_t seed = 1;
};

/// x_A = A_B * x_B, and how well it fits.
struct RobustAlignment {
  Similarity3 A_B;
  std::size_t pairs = 0;
  double inlier_share = 0;
  double rmse_m = 0;        ///< of the inliers' positions
  double max_m = 0;         ///< of all positions
  double rotation_rad = 0;  ///< median difference of orientation; 0 where there are only points

  /// "RMSE 0.081 m over 97.2 % of 892 poses, largest 0.31 m, orientation 0.4 deg, scale 1.0031".
  std::string Summary() const;
};

/// The alignment that most pairs agree with (RANSAC of minimal samples, then least squares over the
/// inliers), whatever the others do. Deterministic. Throws CheckError for sizes that differ or
/// fewer than 3 points. The caller judges the fit.
RobustAlignment AlignPointsRobustly(const std::vector<Eigen::Vector3d>& p_A,
                                    const std::vector<Eigen::Vector3d>& p_B,
                                    const AlignmentOptions& options);

/// Why two trajectories can't be aligned, whatever the fit: fewer than 10 common stamps, or
/// positions on a line so that a rotation about it stays open. Empty when they can.
std::string AlignmentObstacle(const Trajectory& T_A_X,
                              const Trajectory& T_B_X,
                              const AlignmentOptions& options);

/// Aligns two trajectories of the same thing (body or camera), T_A_X and T_B_X, at the stamps of
/// the one with fewer poses. Throws InputError that begins with `what` where there is an
/// AlignmentObstacle and, with the residuals, where the fit is worse than `options` allow.
RobustAlignment AlignTrajectories(const Trajectory& T_A_X,
                                  const Trajectory& T_B_X,
                                  const AlignmentOptions& options,
                                  const std::string& what);

/// T_A_X of T_B_X.
Trajectory Transform(const Similarity3& A_B, const Trajectory& T_B_X);

/// T_A_Y of T_A_X and a fixed T_X_Y, e.g. of the camera from that of the body.
Trajectory Transform(const Trajectory& T_A_X, const Rigid3& T_X_Y);

}  // namespace deja_view
