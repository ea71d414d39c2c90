#include "candidates.hpp"

#include "deja_view/base/angles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view {
namespace {

struct Island {
  double score = 0;
  std::vector<Candidate> members;
};

bool IsBetter(const Candidate& a, const Candidate& b) {
  return a.score != b.score ? a.score > b.score : a.keyframe < b.keyframe;
}

bool Contains(const std::vector<Candidate>& list, int keyframe) {
  return std::any_of(
      list.begin(), list.end(), [&](const Candidate& c) { return c.keyframe == keyframe; });
}

/// Leaves the best entry of every keyframe; entries of one keyframe stand together.
void KeepBestOfEach(std::vector<Candidate>* list) {
  std::vector<Candidate> kept;
  for (const Candidate& candidate : *list) {
    if (kept.empty() || kept.back().keyframe != candidate.keyframe) {
      kept.push_back(candidate);
    } else {
      kept.back().score = std::max(kept.back().score, candidate.score);
    }
  }
  *list = std::move(kept);
}

std::vector<Island> GroupInTime(std::vector<RetrievedPlace> retrieved, double gap_s) {
  std::sort(retrieved.begin(), retrieved.end(), [](const auto& a, const auto& b) {
    return a.keyframe < b.keyframe;
  });
  const auto gap_ns = static_cast<std::int64_t>(gap_s * 1e9);
  std::vector<Island> islands;
  for (std::size_t i = 0; i < retrieved.size(); ++i) {
    const RetrievedPlace& place = retrieved[i];
    const bool is_new = i == 0 || retrieved[i - 1].sequence != place.sequence ||
                        place.stamp_ns - retrieved[i - 1].stamp_ns > gap_ns;
    if (is_new) {
      islands.emplace_back();
    }
    islands.back().score += place.score;
    islands.back().members.push_back({place.keyframe, place.score});
  }
  return islands;
}

}  // namespace

std::vector<Candidate> CandidatesFromIslands(std::vector<RetrievedPlace> retrieved,
                                             const CandidateOptions& options) {
  std::vector<Island> islands = GroupInTime(std::move(retrieved), options.island_gap_s);
  for (Island& island : islands) {
    std::sort(island.members.begin(), island.members.end(), IsBetter);
  }
  std::stable_sort(islands.begin(), islands.end(), [](const Island& a, const Island& b) {
    return a.score > b.score;
  });
  std::vector<Candidate> candidates;
  for (std::size_t rank = 0; rank < static_cast<std::size_t>(options.members_per_island); ++rank) {
    for (const Island& island : islands) {
      if (rank < island.members.size()) {
        candidates.push_back(island.members[rank]);
      }
    }
  }
  return candidates;
}

std::vector<std::vector<RetrievedPlace>> GroupIntoIslands(
    const std::vector<RetrievedPlace>& retrieved, double gap_s) {
  std::vector<std::vector<RetrievedPlace>> islands;
  for (const Island& island : GroupInTime(retrieved, gap_s)) {
    islands.emplace_back();
    for (const RetrievedPlace& place : retrieved) {
      const bool is_member =
          std::any_of(island.members.begin(), island.members.end(), [&](const Candidate& c) {
            return c.keyframe == place.keyframe;
          });
      if (is_member) {
        islands.back().push_back(place);
      }
    }
  }
  return islands;
}

std::vector<Candidate> CandidatesNearby(const std::vector<NearbyPlace>& places,
                                        const NearbyPlace& current,
                                        const CandidateOptions& options) {
  const double min_cosine = std::cos(options.nearby_angle_deg * kDegree);
  const double max_squared = options.nearby_distance_m * options.nearby_distance_m;
  const Eigen::Vector3d axis_M = current.axis_M();
  std::vector<Candidate> found;  // score: minus the cost, for sorting only
  for (const NearbyPlace& place : places) {
    const double squared = (place.T_M_C.t - current.T_M_C.t).squaredNorm();
    const double cosine = place.axis_M().dot(axis_M);
    if (squared < max_squared && cosine > min_cosine) {
      const double angle = std::acos(std::min(1.0, cosine)) / (options.nearby_angle_deg * kDegree);
      found.push_back({place.keyframe, -(std::sqrt(squared / max_squared) + angle)});
    }
  }
  KeepBestOfEach(&found);
  const auto count = std::min<std::size_t>(found.size(), static_cast<std::size_t>(options.nearby));
  std::partial_sort(
      found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count), found.end(), IsBetter);
  found.resize(count);
  for (Candidate& candidate : found) {
    candidate.score = 0;
  }
  return found;
}

std::vector<Candidate> MergeCandidates(const std::vector<Candidate>& retrieved,
                                       const std::vector<Candidate>& nearby,
                                       bool is_localised,
                                       const CandidateOptions& options) {
  std::vector<Candidate> merged;
  const auto append = [&](const Candidate& candidate) {
    if (static_cast<int>(merged.size()) < options.max_verified &&
        !Contains(merged, candidate.keyframe)) {
      merged.push_back(candidate);
      for (const Candidate& r : retrieved) {
        if (r.keyframe == candidate.keyframe) {
          merged.back().score = r.score;
        }
      }
    }
  };
  // Alternate, so that neither source crowds out the other.
  const auto& first = is_localised ? nearby : retrieved;
  const auto& second = is_localised ? retrieved : nearby;
  for (std::size_t i = 0; i < std::max(first.size(), second.size()); ++i) {
    if (i < first.size()) {
      append(first[i]);
    }
    if (i < second.size()) {
      append(second[i]);
    }
  }
  return merged;
}

}  // namespace deja_view
