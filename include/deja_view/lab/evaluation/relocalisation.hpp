#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/lab/evaluation/loop_score.hpp"

#include <vector>

namespace deja_view {

/// How keyframes fared whose offset from the map is in [from, to).
struct RelocalisationBin {
  double from = 0;
  double to = 0;
  int keyframes = 0;
  int found = 0;
};

/// How far off the mapped places a keyframe can be and still be found.
struct RelocalisationCurve {
  /// By the distance [m] to the nearest place that looks the same way within 30 degrees.
  std::vector<RelocalisationBin> by_distance;
  /// By the angle [deg] between the viewing directions to the most aligned place within 1.5 m.
  std::vector<RelocalisationBin> by_angle;
};

/// `places`: the map's, `current`: the keyframes that look for them, `is_found`: one per keyframe,
/// true when it was tied to the map rightly. Those without a true pose, or without any place that
/// they could be compared with, are left out, and so is what lies beyond the last bin. `T_B_C`
/// gives the viewing direction, the camera's z.
RelocalisationCurve MakeRelocalisationCurve(const std::vector<TrueKeyframe>& places,
                                            const std::vector<TrueKeyframe>& current,
                                            const std::vector<bool>& is_found,
                                            const Rigid3& T_B_C);

}  // namespace deja_view
