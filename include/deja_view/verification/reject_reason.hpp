#pragma once

#include "deja_view/base/enum_names.hpp"

#include <array>
#include <utility>

namespace deja_view {

/// Why a loop candidate, or a keyframe, did not lead to a loop constraint.
enum class RejectReason {
  kNone,            ///< accepted
  kNoCandidate,     ///< the database found nothing similar enough
  kTooFewPoints,    ///< the keyframes bring too few tracked points to solve a pose
  kTooFewMatches,   ///< descriptor matches
  kTooFewInliers,   ///< of the robust pose
  kByChance,        ///< a wrong pose may well find as many, spread as they are
  kLowInlierRatio,  ///< too few of the points that should be visible were found
  kTooFar,          ///< distance between the two bodies
  kTooMuchYaw,      ///< angle between the two headings
  kGravity,         ///< roll or pitch disagree with the VIO's
  kUncertain,       ///< covariance of the pose too large
  kInconsistent,    ///< not (yet) supported by other loops, or contradicted by them
  kImplausible,     ///< would need far more drift than the VIO can have
  kWithdrawn,       ///< was accepted, and later loops contradicted it
};

constexpr int kRejectReasonCount = static_cast<int>(RejectReason::kWithdrawn) + 1;

/// As in loops.csv and the diagnostics.
template <>
struct EnumNames<RejectReason> {
  static constexpr std::array<std::pair<RejectReason, const char*>, kRejectReasonCount> kNames = {
      {{RejectReason::kNone, "accepted"},
       {RejectReason::kNoCandidate, "no_candidate"},
       {RejectReason::kTooFewPoints, "too_few_points"},
       {RejectReason::kTooFewMatches, "too_few_matches"},
       {RejectReason::kTooFewInliers, "too_few_inliers"},
       {RejectReason::kByChance, "by_chance"},
       {RejectReason::kLowInlierRatio, "low_inlier_ratio"},
       {RejectReason::kTooFar, "too_far"},
       {RejectReason::kTooMuchYaw, "too_much_yaw"},
       {RejectReason::kGravity, "gravity"},
       {RejectReason::kUncertain, "uncertain"},
       {RejectReason::kInconsistent, "inconsistent"},
       {RejectReason::kImplausible, "implausible"},
       {RejectReason::kWithdrawn, "withdrawn"}}};
};

}  // namespace deja_view
