#pragma once

#include "deja_view/base/enum_names.hpp"

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
inline constexpr auto kEnumNames<RejectReason> = EnumNames("accepted",
                                                           "no_candidate",
                                                           "too_few_points",
                                                           "too_few_matches",
                                                           "too_few_inliers",
                                                           "by_chance",
                                                           "low_inlier_ratio",
                                                           "too_far",
                                                           "too_much_yaw",
                                                           "gravity",
                                                           "uncertain",
                                                           "inconsistent",
                                                           "implausible",
                                                           "withdrawn");
static_assert(kEnumNames<RejectReason>.size() == kRejectReasonCount);

}  // namespace deja_view
