#include "deja_view/verification/reject_reason.hpp"

namespace deja_view {

std::string ToString(RejectReason reason) {
  switch (reason) {
    case RejectReason::kNone:
      return "accepted";
    case RejectReason::kNoCandidate:
      return "no_candidate";
    case RejectReason::kTooFewPoints:
      return "too_few_points";
    case RejectReason::kTooFewMatches:
      return "too_few_matches";
    case RejectReason::kTooFewInliers:
      return "too_few_inliers";
    case RejectReason::kByChance:
      return "by_chance";
    case RejectReason::kLowInlierRatio:
      return "low_inlier_ratio";
    case RejectReason::kTooFar:
      return "too_far";
    case RejectReason::kTooMuchYaw:
      return "too_much_yaw";
    case RejectReason::kGravity:
      return "gravity";
    case RejectReason::kUncertain:
      return "uncertain";
    case RejectReason::kInconsistent:
      return "inconsistent";
    case RejectReason::kImplausible:
      return "implausible";
  }
  return "unknown";
}

}  // namespace deja_view
