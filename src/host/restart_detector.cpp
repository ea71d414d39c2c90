#include "deja_view/host/restart_detector.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace deja_view {
namespace {

// So few points say nothing.
constexpr std::size_t kFewPoints = 8;

// A VIO refines its points; in a new world they are elsewhere. Of the distance from the camera, and
// at least [m].
constexpr double kMovedShare = 0.5;
constexpr double kMovedMetres = 0.5;

// Points that stay about as far away, but for this factor, have moved as a whole; those that a VIO
// refines, as after its first keyframes, have not.
constexpr double kRangeRatio = 2.0;

// How wrong it may be that an aircraft flies on as before: at once [m], by the noise of a VIO
// [m/s], and by the aircraft's own doing [m/s^2].
constexpr double kStepMetres = 1.0;
constexpr double kStepSpeed = 1.0;
constexpr double kAcceleration = 5.0;
// A VIO that flew on through more than this would have kept a track; and a new sequence that was
// none is joined by its next loop, while a restart that is not told bends the map.
constexpr double kLostTracksAcceleration = 2.0;

// Whether it can't have come by `step` [m] after it flew with `velocity` [m/s].
bool IsUnexplainedStep(const Eigen::Vector3d& step,
                       const Eigen::Vector3d& velocity,
                       double elapsed_s,
                       double acceleration) {
  const double limit_m = kStepMetres + elapsed_s * (kStepSpeed + 0.5 * acceleration * elapsed_s);
  return (step - elapsed_s * velocity).norm() > limit_m;
}

using PointsById = std::unordered_map<std::int64_t, Eigen::Vector3d>;

double Seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

// Median of the distances that common points moved, over how far they are from the camera.
bool HaveMoved(std::vector<std::pair<double, double>> moved_and_range) {
  const auto middle =
      moved_and_range.begin() + static_cast<std::ptrdiff_t>(moved_and_range.size() / 2);
  std::nth_element(
      moved_and_range.begin(), middle, moved_and_range.end(), [](const auto& a, const auto& b) {
        return a.first * b.second < b.first * a.second;
      });
  return middle->first > std::max(kMovedMetres, kMovedShare * middle->second);
}

// Median distance from the body to those of `points` that are in `others`, too.
double MedianRange(const PointsById& points, const PointsById& others, const Eigen::Vector3d& p_W) {
  std::vector<double> ranges;
  for (const auto& [id, point_W] : points) {
    if (others.count(id) > 0) {
      ranges.push_back((point_W - p_W).norm());
    }
  }
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return *middle;
}

}  // namespace

bool RestartDetector::Add(std::int64_t stamp_ns,
                          const Rigid3& T_W_B,
                          const std::vector<TrackedPoint>& points) {
  Keyframe now{stamp_ns, T_W_B.t, {}};
  for (const TrackedPoint& point : points) {
    if (point.feature_id >= 0) {
      now.points_W.emplace(point.feature_id, point.p_W);
    }
  }
  const MovedAndRange common = CommonPoints(now);
  const bool is_restart = last_ && IsRestart(now, common);
  const double elapsed_s = last_ ? Seconds(last_->stamp_ns, stamp_ns) : 0;
  velocity_.reset();
  if (!is_restart && elapsed_s > 0) {
    velocity_ = (now.p_W - last_->p_W) / elapsed_s;
  }
  keeps_tracks_ = !common.empty();
  last_ = std::move(now);
  return is_restart;
}

void RestartDetector::Reset() {
  last_.reset();
  velocity_.reset();
  keeps_tracks_ = false;
}

RestartDetector::MovedAndRange RestartDetector::CommonPoints(const Keyframe& now) const {
  MovedAndRange common;
  for (const auto& [id, p_W] : now.points_W) {
    if (!last_) {
      break;
    }
    if (const auto before = last_->points_W.find(id); before != last_->points_W.end()) {
      common.emplace_back((p_W - before->second).norm(), (p_W - now.p_W).norm());
    }
  }
  return common;
}

bool RestartDetector::IsRestart(const Keyframe& now, const MovedAndRange& common) const {
  if (common.size() >= kFewPoints) {
    const double before = MedianRange(last_->points_W, now.points_W, last_->p_W);
    const double after = MedianRange(now.points_W, last_->points_W, now.p_W);
    const bool is_whole = after < kRangeRatio * before && before < kRangeRatio * after;
    return HaveMoved(common) && (is_whole || IsUnexplained(now, kAcceleration));
  }
  if (!keeps_tracks_ || !common.empty()) {
    return false;
  }
  return Seconds(last_->stamp_ns, now.stamp_ns) >= max_silence_s_ ||
         (now.points_W.size() >= kFewPoints && IsUnexplained(now, kLostTracksAcceleration));
}

bool RestartDetector::IsUnexplained(const Keyframe& now, double acceleration) const {
  if (!velocity_) {
    return false;
  }
  return IsUnexplainedStep(
      now.p_W - last_->p_W, *velocity_, Seconds(last_->stamp_ns, now.stamp_ns), acceleration);
}

bool IsJump(const StampedPose& before, const StampedPose& last, const StampedPose& now) {
  const Eigen::Vector3d velocity =
      (last.pose.t - before.pose.t) / Seconds(before.stamp_ns, last.stamp_ns);
  return IsUnexplainedStep(
      now.pose.t - last.pose.t, velocity, Seconds(last.stamp_ns, now.stamp_ns), kAcceleration);
}

std::string RestartText(std::int64_t stamp_ns) {
  return fmt::format("the VIO started anew before stamp {} ns: a new sequence", stamp_ns);
}

}  // namespace deja_view
