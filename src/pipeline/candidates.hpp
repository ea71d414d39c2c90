#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/place/place_database.hpp"

#include <cstdint>
#include <vector>

namespace deja_view {

/// An old keyframe to verify.
struct Candidate {
  int keyframe = -1;
  double score = 0;  ///< place score; 0 when only its position spoke for it
};

/// A retrieved keyframe with its place in time.
struct RetrievedPlace {
  int keyframe = -1;
  double score = 0;
  int sequence = 0;
  std::int64_t stamp_ns = 0;
};

/// Groups retrieved keyframes that are close in time into islands, orders the islands by the sum of
/// their scores, and lists the best members of each: the best member of every island first, then
/// the second best ones. Deterministic; ties go to the lower index.
std::vector<Candidate> CandidatesFromIslands(std::vector<RetrievedPlace> retrieved,
                                             const CandidateOptions& options);

/// Retrieved keyframes in islands as above, each in the order of retrieval.
std::vector<std::vector<RetrievedPlace>> GroupIntoIslands(
    const std::vector<RetrievedPlace>& retrieved, double gap_s);

/// Old keyframes whose corrected camera pose is near the current one's.
struct NearbyPlace {
  int keyframe = -1;
  Rigid3 T_M_C;  ///< [m]

  Eigen::Vector3d axis_M() const { return T_M_C.q * Eigen::Vector3d::UnitZ(); }
};

/// The nearest `options.nearby` keyframes, best first: distance over its limit plus angle over its
/// limit. A keyframe's places (its own camera's and its virtual ones') stand together; the nearest
/// one counts.
std::vector<Candidate> CandidatesNearby(const std::vector<NearbyPlace>& places,
                                        const NearbyPlace& current,
                                        const CandidateOptions& options);

/// Both lists as one, without repetition, at most options.max_verified long. When the drone is
/// localised its position is the better guess and its nearest place goes first; otherwise the
/// places that look alike do.
std::vector<Candidate> MergeCandidates(const std::vector<Candidate>& retrieved,
                                       const std::vector<Candidate>& nearby,
                                       bool is_localised,
                                       const CandidateOptions& options);

}  // namespace deja_view
