#pragma once

#include "deja_view/triangulation/motion_stereo.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <cstdint>
#include <limits>

namespace deja_view {

/// In `KeyframeFeatures::point_ids`: the point is a corner of ours, and no track of the VIO. Such
/// points follow those of the VIO.
inline constexpr std::int64_t kOwnPoint = std::numeric_limits<std::int64_t>::min();

/// Puts the best corners of `view`, the keyframe's, in the place of the own points that the
/// keyframe had.
void ReplaceOwnPoints(const CornerView& view,
                      const Camera& camera,
                      const MotionStereoOptions& options,
                      KeyframeFeatures* features);

/// Median distance [m] of the keyframe's points from its camera; a room's where there are too few.
double MedianDepth(const KeyframeFeatures& features);

}  // namespace deja_view
