#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/host/odometry_input.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// Tells from its keyframes alone when a VIO has started anew, in another world than before:
///   - the points that it still tracks have moved in its world, as a whole, or while it came to
///     where its motion before could not have brought it; or
///   - it tracks none of the points that it did, and came to such a place, or was silent before for
///     `max_silence_s`.
/// A VIO that refines its points, or loses its tracks and flies on, has its old world; one that
/// starts anew where it was before does no harm. Hosts that name their points anew in each keyframe
/// tell nothing.
class RestartDetector {
 public:
  explicit RestartDetector(double max_silence_s = 1.0) : max_silence_s_(max_silence_s) {}

  /// Keyframes in the order of their stamps. True when this one is the first of a new start.
  bool Add(std::int64_t stamp_ns, const Rigid3& T_W_B, const std::vector<TrackedPoint>& points);

  /// Forgets what came: a sequence starts for another reason.
  void Reset();

 private:
  struct Keyframe {
    std::int64_t stamp_ns = 0;
    Eigen::Vector3d p_W;
    std::unordered_map<std::int64_t, Eigen::Vector3d> points_W;  ///< by feature id
  };
  using MovedAndRange = std::vector<std::pair<double, double>>;
  MovedAndRange CommonPoints(const Keyframe& now) const;
  bool IsRestart(const Keyframe& now, const MovedAndRange& common) const;
  /// By the motion before and so much acceleration [m/s^2].
  bool IsUnexplained(const Keyframe& now, double acceleration) const;

  // A VIO that flies on is not silent for so long where it sees new points all the time; one that
  // starts anew needs a second for its first window, and may come to anywhere.
  double max_silence_s_;
  std::optional<Keyframe> last_;
  std::optional<Eigen::Vector3d> velocity_;  ///< [m/s] between the last two keyframes
  bool keeps_tracks_ = false;                ///< the last two keyframes have points in common
};

/// Whether a body can't have come from `last` to `now` after it flew from `before` to `last`;
/// stamps ascend.
bool IsJump(const StampedPose& before, const StampedPose& last, const StampedPose& now);

/// What is told of a restart whose first keyframe is this one.
std::string RestartText(std::int64_t stamp_ns);

}  // namespace deja_view
