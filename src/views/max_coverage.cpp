#include "max_coverage.hpp"

#include <algorithm>
#include <queue>

namespace deja_view {

void MaxCoverage::Raise(std::size_t q, double degree) {
  covered_[q] = std::max(covered_[q], degree);
}

void MaxCoverage::Add(std::size_t q, std::size_t v, double degree) {
  if (degree > 0) {
    by_element_[q].push_back({v, degree});
  }
}

double MaxCoverage::Gain(const std::vector<Degree>& set) const {
  double gain = 0;
  for (const Degree& element : set) {
    gain += std::max(0.0, element.degree - covered_[element.number]);
  }
  return gain;
}

// What a set adds only falls while others are taken, so that one whose gain of today is above what
// all others had at some time is the best (Minoux 1978).
std::vector<std::size_t> MaxCoverage::Choose(std::size_t budget, double min_gain) {
  std::vector<std::vector<Degree>> sets(by_element_.size());
  for (std::size_t q = 0; q < by_element_.size(); ++q) {
    for (const Degree& set : by_element_[q]) {
      sets[set.number].push_back({q, set.degree});
    }
  }
  struct Bound {
    double gain;
    std::size_t set;
    bool operator<(const Bound& other) const {
      return gain < other.gain || (gain == other.gain && set > other.set);
    }
  };
  std::priority_queue<Bound> bounds;
  for (std::size_t v = 0; v < sets.size(); ++v) {
    bounds.push({Gain(sets[v]), v});
  }
  std::vector<std::size_t> chosen;
  while (chosen.size() < budget && !bounds.empty()) {
    const std::size_t v = bounds.top().set;
    bounds.pop();
    const Bound now{Gain(sets[v]), v};
    if (now.gain < min_gain) {
      continue;
    }
    if (!bounds.empty() && now < bounds.top()) {
      bounds.push(now);
      continue;
    }
    chosen.push_back(v);
    for (const Degree& element : sets[v]) {
      Raise(element.number, element.degree);
    }
  }
  return chosen;
}

}  // namespace deja_view
