#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstddef>
#include <cstdint>
#include <utility>
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

/// What is aligned with the truth before errors are taken.
enum class ApeAlignment {
  kSe3,  ///< rotation and position, as `evo_ape -a`
  kYaw,  ///< yaw and position alone: what a VIO, which knows gravity, leaves open
  kNone  ///< nothing, as `evo_ape` without -a
};

template <>
inline constexpr auto kEnumNames<ApeAlignment> = EnumNames("se3", "yaw", "none");

/// Poses that are compared: for each of the shorter trajectory the one of nearest stamp in the
/// other, where it is at most `max_difference_ns` away; of two equally near ones the earlier.
/// Indices (first, second), in order. This is how evo pairs poses; nothing is interpolated.
std::vector<std::pair<std::size_t, std::size_t>> PairByStamp(
    const std::vector<std::int64_t>& first_ns,
    const std::vector<std::int64_t>& second_ns,
    std::int64_t max_difference_ns);

/// Absolute pose error of the positions, pose by pose, after least-squares alignment in SE(3)
/// without scale: what `evo_ape tum ... -a` prints, or after another alignment. Both lists pair up
/// by index; at least 3 poses, without alignment at least 1.
ApeStatistics ComputeApe(const std::vector<Eigen::Vector3d>& truth,
                         const std::vector<Eigen::Vector3d>& estimate,
                         ApeAlignment alignment = ApeAlignment::kSe3);

/// The same without any alignment: both are in one frame already.
ApeStatistics ComputeApeUnaligned(const std::vector<Eigen::Vector3d>& truth,
                                  const std::vector<Eigen::Vector3d>& estimate);

}  // namespace deja_view
