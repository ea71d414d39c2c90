#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/verification/loop_verifier.hpp"
#include "deja_view/verification/reject_reason.hpp"

#include <cstdint>
#include <functional>
#include <future>
#include <optional>
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
  double scene_depth = 5.0;                ///< [m] median distance of the inliers' points
  double score = 0;                        ///< place score of the candidate
  int matches = 0;
  int inliers = 0;
  bool is_virtual =
      false;  ///< judged with virtual views, since the real image alone was not enough
  RejectReason reason = RejectReason::kNone;

  bool accepted() const { return reason == RejectReason::kNone; }
};

/// One tracked point of the current keyframe that was found in the old image; what VINS-Mono's fast
/// relocalisation wants.
struct RelocalisationPoint {
  std::int64_t feature_id = -1;
  Eigen::Vector2d normalised_old = Eigen::Vector2d::Zero();  ///< x/z, y/z in the old camera
};

/// The best accepted loop of a keyframe, for `/pose_graph/match_points`.
struct Relocalisation {
  int old = -1;     ///< index of the old keyframe
  Rigid3 T_M_Bold;  ///< corrected pose of the old body; VINS-Mono takes it for the pose in its
                    ///< loop-closed world
  std::vector<RelocalisationPoint> points;
};

/// What an accepted loop rests on, to show it.
struct LoopMatches {
  struct Pair {
    int view = -1;  ///< index of the old keyframe's virtual view; -1: its real image
    Eigen::Vector2f old_pixel = Eigen::Vector2f::Zero();  ///< [px] in that image
    Eigen::Vector2f current_pixel = Eigen::Vector2f::Zero();
  };
  std::int64_t stamp_current_ns = 0;
  std::int64_t stamp_old_ns = 0;
  bool is_virtual = false;
  std::vector<Pair> pairs;
};

/// Wall time of one keyframe's steps [ms].
struct KeyframeTimes {
  double features = 0, words = 0, query = 0, verification = 0, graph = 0;
  double total() const { return features + words + query + verification + graph; }
};

/// The past keyframe that looks most like a new one, and what its island scores: with the paper's
/// scoring the number that is compared with r, else the place database's score.
struct BestPlace {
  int old = -1;
  double score = 0;
};

/// Why two keyframes were joined or not.
struct PairExplanation {
  /// One way to verify the pair.
  struct Attempt {
    Verification verification;
    std::vector<GateReading> readings;     ///< where a pose was found; else empty
    std::vector<LoopMatches::Pair> pairs;  ///< its inliers
  };
  int current = -1;  ///< index of the keyframe
  int old = -1;
  std::int64_t stamp_current_ns = 0;
  std::int64_t stamp_old_ns = 0;
  bool is_place = false;   ///< the old keyframe can be recognised
  int candidates = 0;      ///< keyframes that were tried in the flight
  int rank = -1;           ///< of the old one among them, from 0; -1: it was not tried
  double score = 0;        ///< its place score, if it was
  int points_current = 0;  ///< points with a known place
  int points_old = 0;
  std::optional<Rigid3> T_Bold_Bcurrent_predicted;  ///< by the odometry and the loops before
  double predicted_overlap = 0;  ///< share of the current points that the old image then shows
  Attempt real;                  ///< by the two images alone
  std::optional<Attempt> with_views;
  std::vector<PixelMatch> first_matches;  ///< of the real images, before geometry
  /// The flight's own decision; of a pair that was not tried, what it would have come to but for
  /// its agreement with other loops.
  RejectReason reason = RejectReason::kNoCandidate;
};

/// What AddKeyframe did.
struct KeyframeReport {
  int index = -1;
  int sequence = 0;
  bool is_new_sequence = false;
  RejectReason reason = RejectReason::kNoCandidate;  ///< kNone when at least one loop was accepted
  /// Candidates verified for this keyframe, and loops of earlier keyframes that became consistent
  /// (or were found inconsistent) now. A pair may be reported twice: first kInconsistent (pending),
  /// later accepted; and once more, kWithdrawn, when the graph contradicts an accepted one: it is
  /// gone from graph and map.
  std::vector<LoopReport> loops;
  std::optional<BestPlace> best_place;  ///< whether or not it reached any threshold
  std::optional<Relocalisation> relocalisation;
  std::vector<LoopMatches> matches;  ///< of this keyframe's own loops that were accepted at once
  std::optional<PairExplanation> explanation;  ///< if asked for: LoopCloser::Ask
  bool graph_changed = false;                  ///< optimised poses moved: publish paths anew
  bool separates = false;  ///< the flight's join to another world was wrong: it was taken back
  KeyframeTimes times;
};

/// Read access to a stored keyframe.
struct KeyframeInfo {
  int index = -1;
  int sequence = 0;
  std::int64_t stamp_ns = 0;
  Rigid3 T_W_B;           ///< as received from the VIO
  Rigid3 T_M_B;           ///< corrected by the pose graph
  bool is_place = false;  ///< can be recognised
  int views = 0;          ///< virtual views kept
};

/// Runs a graph solve somewhere (the node: on its solver thread) and returns how to wait for its
/// end.
using SolveExecutor = std::function<std::future<void>(std::function<void()>)>;

}  // namespace deja_view
