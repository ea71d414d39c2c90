#include "image_pairs.hpp"

#include "deja_view/base/angles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace deja_view::internal {
namespace {

struct Candidate {
  int image = -1;
  double cost = 0;
};

/// Older images by visit: runs of candidates without a gap longer than the neighbours.
std::vector<std::vector<Candidate>> FindVisits(const BundleOptions& options,
                                               const std::vector<Rigid3>& poses,
                                               int image) {
  const Rigid3& T = poses[static_cast<std::size_t>(image)];
  const Eigen::Vector3d axis = T.q * Eigen::Vector3d::UnitZ();
  std::vector<std::vector<Candidate>> visits;
  int last = image;
  for (int other = image - options.neighbours - 1; other >= 0; --other) {
    const Rigid3& T_other = poses[static_cast<std::size_t>(other)];
    const double distance = (T.t - T_other.t).norm() / options.reach_m;
    const double cosine = std::clamp(axis.dot(T_other.q * Eigen::Vector3d::UnitZ()), -1.0, 1.0);
    const double angle = ToDegrees(std::acos(cosine)) / options.max_view_deg;
    if (distance > 1 || angle > 1) {
      continue;
    }
    if (visits.empty() || last - other > std::max(1, options.neighbours)) {
      visits.emplace_back();
    }
    visits.back().push_back({other, distance + angle});
    last = other;
  }
  for (std::vector<Candidate>& visit : visits) {
    std::stable_sort(visit.begin(), visit.end(), [](const Candidate& a, const Candidate& b) {
      return a.cost < b.cost;
    });
  }
  return visits;
}

/// One of each visit in turn, none right beside one that was chosen before.
std::vector<int> ChooseOverlapping(const BundleOptions& options,
                                   const std::vector<std::vector<Candidate>>& visits) {
  std::vector<int> chosen;
  std::vector<std::size_t> next(visits.size(), 0);
  const auto is_beside = [&](int image) {
    return std::any_of(chosen.begin(), chosen.end(), [&](int other) {
      return std::abs(image - other) <= options.neighbours;
    });
  };
  const auto wanted = static_cast<std::size_t>(options.overlapping);
  for (bool found = true; found && chosen.size() < wanted;) {
    found = false;
    for (std::size_t v = 0; v < visits.size() && chosen.size() < wanted; ++v) {
      while (next[v] < visits[v].size() && is_beside(visits[v][next[v]].image)) {
        ++next[v];
      }
      if (next[v] < visits[v].size()) {
        chosen.push_back(visits[v][next[v]++].image);
        found = true;
      }
    }
  }
  return chosen;
}

}  // namespace

std::vector<std::pair<int, int>> ChooseImagePairs(const BundleOptions& options,
                                                  const BundleProblem& problem) {
  std::vector<Rigid3> poses;
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    poses.push_back(problem.CameraPose(static_cast<int>(i)));
  }
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < static_cast<int>(poses.size()); ++i) {
    for (int k = 1; k <= std::min(options.neighbours, i); ++k) {
      pairs.emplace_back(i - k, i);
    }
    for (const int other : ChooseOverlapping(options, FindVisits(options, poses, i))) {
      pairs.emplace_back(other, i);
    }
  }
  for (const BundleLoop& loop : problem.loops) {
    if (loop.from != loop.to) {
      pairs.emplace_back(std::min(loop.from, loop.to), std::max(loop.from, loop.to));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace deja_view::internal
