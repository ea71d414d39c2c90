#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// Statistics of the absolute position error [m].
struct ApeStatistics {
  double max = 0;
  double mean = 0;
  double median = 0;
  double min = 0;
  double rmse = 0;
  std::vector<double> errors;  ///< per pose
  Rigid3 T_truth_estimate;     ///< the alignment that was applied
};

/// Absolute pose error of the positions, pose by pose, after least-squares alignment in SE(3)
/// without scale: what `evo_ape tum ... -a` prints. Both lists pair up by index; at least 3 poses.
ApeStatistics ComputeApe(const std::vector<Eigen::Vector3d>& truth,
                         const std::vector<Eigen::Vector3d>& estimate);

/// The same without any alignment: both are in one frame already.
ApeStatistics ComputeApeUnaligned(const std::vector<Eigen::Vector3d>& truth,
                                  const std::vector<Eigen::Vector3d>& estimate);

}  // namespace deja_view
