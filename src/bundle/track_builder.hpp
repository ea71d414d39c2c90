#pragma once

#include "deja_view/bundle/bundle_problem.hpp"

#include <vector>

#include "image_matching.hpp"

namespace deja_view::internal {

/// A set of keypoints of different images, ascending, that show one thing.
using Track = std::vector<BundleObservation>;

/// Joins what the VIO tracked and what was matched: first the VIO's tracks, each keypoint with the
/// one before, then the matches, the most alike first. A join that would put two keypoints of one
/// image into a track is left out. Tracks of two keypoints or more, in the order of their first.
std::vector<Track> BuildTracks(const BundleProblem& problem,
                               const std::vector<KeypointMatch>& matches);

}  // namespace deja_view::internal
