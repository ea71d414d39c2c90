#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace deja_view {

/// What counts as a correct loop and as a revisit.
struct LoopCriteria {
  double max_error_m = 0.5;         ///< [m] of the relative position
  double max_error_deg = 10.0;      ///< [deg] of the relative rotation
  double revisit_age_s = 10.0;      ///< [s] the old keyframe is at least this much older
  double revisit_distance_m = 2.0;  ///< [m] between the bodies
  double revisit_angle_deg = 40.0;  ///< [deg] between the viewing directions
};

/// A keyframe with its true pose, where the truth covers it.
struct TrueKeyframe {
  std::int64_t stamp_ns = 0;
  std::optional<Rigid3> T_truth_B;
  bool is_old_only = false;  ///< of a loaded map: can be revisited, is no revisit itself
};

/// An accepted loop between two keyframes, by index into the list of keyframes.
struct EvaluatedLoop {
  int old = -1;
  int current = -1;
  Rigid3 T_Bold_Bcurrent;
};

/// Of a relative pose.
struct LoopError {
  double distance_m = 0;
  double angle_deg = 0;
};

struct LoopScore {
  int accepted = 0;
  int judged = 0;  ///< accepted loops whose two ends have a true pose
  int correct = 0;
  int revisits = 0;              ///< keyframes that the truth says revisit
  int revisits_found = 0;        ///< of those, the ones with a correct loop
  std::vector<bool> is_correct;  ///< per loop
  LoopError worst;               ///< of the judged ones, position and rotation each by itself

  double precision() const { return judged > 0 ? 1.0 * correct / judged : 1.0; }
  double recall() const { return revisits > 0 ? 1.0 * revisits_found / revisits : 0.0; }
};

/// True when `current` sees the place of `old` again: near enough, looking the same way, and later
/// by long enough. False where the truth is unknown. `T_B_C` gives the viewing direction, the
/// camera's z.
bool IsRevisit(const TrueKeyframe& current,
               const TrueKeyframe& old,
               const Rigid3& T_B_C,
               const LoopCriteria& criteria = {});

/// How far a loop's relative pose is from the true one; nothing where the truth does not cover both
/// ends.
std::optional<LoopError> ErrorOf(const std::vector<TrueKeyframe>& keyframes,
                                 const EvaluatedLoop& loop);

bool IsWithin(const LoopError& error, const LoopCriteria& criteria);

/// Judges loops against the truth; recall counts keyframes. `T_B_C` gives the viewing direction,
/// the camera's z. Keyframes of a loaded map are old whatever their stamps say.
LoopScore ScoreLoops(const std::vector<TrueKeyframe>& keyframes,
                     const std::vector<EvaluatedLoop>& loops,
                     const Rigid3& T_B_C,
                     const LoopCriteria& criteria = {});

}  // namespace deja_view
