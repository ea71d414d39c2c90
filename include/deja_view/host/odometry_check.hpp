#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/keyframe_input.hpp"

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// How far an odometry flew and how fast.
struct MotionFigures {
  double path_m = 0;
  double median_mps = 0;
  double max_mps = 0;
};

/// Poses in the order of their stamps, which differ.
MotionFigures MeasureMotion(const std::vector<std::int64_t>& stamps_ns,
                            const std::vector<Rigid3>& poses);

/// Which way is up in a world: the direction to which the rows of the images (the cameras' x axes)
/// are most nearly level, right for a camera that is held about upright while it turns. Either of
/// the two signs. Nothing for cameras that turned too little to tell.
std::optional<Eigen::Vector3d> UpFromLevelRows(const std::vector<Rigid3>& T_W_C);

/// The same of the mean of row * row^T over the rows [unit vectors in W]. `least_spread` is that
/// across the second direction: 0.02 is some 15 degrees of turning, 0.1 some 65.
std::optional<Eigen::Vector3d> UpFromRowSpread(const Eigen::Matrix3d& spread, double least_spread);

/// Median distance [px] between the points' own pixels and where camera and poses put them; nothing
/// when none can be projected. It is a pixel or two when calibration and extrinsics are right.
std::optional<double> MedianReprojection(const Rigid3& T_W_C,
                                         const std::vector<TrackedPoint>& points,
                                         const Camera& camera);

}  // namespace deja_view
