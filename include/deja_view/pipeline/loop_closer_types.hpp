#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/verification/reject_reason.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What became of a virtual view when it was added.
enum class ViewOutcome {
  kKept,       ///< indexed under its keyframe
  kWaiting,    ///< its keyframe has not come yet
  kDuplicate,  ///< its keyframe has a view of that index already
  kNoPlace,    ///< its keyframe is not kept as a place to recognise
  kUncertain,  ///< too little of it is certain
  kDisagrees,  ///< it does not show what its own source image shows
  kSurpassed,  ///< other views of its keyframe are more like the source image
};

/// Virtual views so far.
struct ViewCounts {
  std::int64_t received = 0;
  std::int64_t kept = 0;     ///< held now
  std::int64_t waiting = 0;  ///< held now, without a keyframe
  std::int64_t duplicates = 0;
  std::int64_t refused = 0;      ///< malformed: InputError
  std::int64_t no_keyframe = 0;  ///< given up waiting: the store was full
  std::int64_t no_place = 0;
  std::int64_t uncertain = 0;
  std::int64_t disagree = 0;
  std::int64_t surpassed = 0;
};

/// A verified candidate pair, accepted or not.
struct LoopReport {
  int current = -1;  ///< index of the keyframe
  int old = -1;
  std::int64_t stamp_current_ns = 0;
  std::int64_t stamp_old_ns = 0;
  Rigid3 T_Bold_Bcurrent;                  ///< measured relative pose [m]
  Matrix6d covariance = Matrix6d::Zero();  ///< of (t [m], rotation vector [rad]) in frame Bold
  double score = 0;                        ///< place score of the candidate
  int matches = 0;
  int inliers = 0;
  bool is_virtual =
      false;  ///< judged with virtual views, since the real image alone was not enough
  RejectReason reason = RejectReason::kNone;

  bool accepted() const { return reason == RejectReason::kNone; }
};

}  // namespace deja_view
