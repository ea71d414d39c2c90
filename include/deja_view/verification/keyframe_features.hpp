#pragma once

#include "deja_view/features/types.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// What verification needs of a keyframe: the corners of its image and the points that the VIO
/// tracked in it. Single precision: 1 mm at 100 m, 1e-4 px.
struct KeyframeFeatures {
  Rigid3 T_B_C;
  std::vector<Eigen::Vector2f> keypoints;     ///< [px]
  std::vector<Descriptor> descriptors;        ///< of the keypoints
  std::vector<Eigen::Vector3f> points_B;      ///< [m] tracked points in the body frame
  std::vector<Eigen::Vector2f> point_pixels;  ///< [px] where the VIO tracked them
  std::vector<float> point_depth_sigmas;      ///< [m] along the camera's ray
  std::vector<std::int64_t> point_ids;        ///< the VIO's feature ids
  std::vector<Descriptor> point_descriptors;  ///< described at point_pixels

  std::size_t MemoryBytes() const;
};

}  // namespace deja_view
