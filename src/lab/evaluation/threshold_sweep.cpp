#include "deja_view/lab/evaluation/threshold_sweep.hpp"

#include <algorithm>
#include <limits>

namespace deja_view {

std::vector<SweepPoint> SweepThreshold(std::vector<ScoredDecision> decisions, int revisits) {
  std::stable_sort(decisions.begin(), decisions.end(), [](const auto& a, const auto& b) {
    return a.score > b.score;
  });
  std::vector<SweepPoint> sweep;
  int found = 0;
  int correct = 0;
  int recalled = 0;
  for (std::size_t i = 0; i < decisions.size(); ++i) {
    const ScoredDecision& decision = decisions[i];
    ++found;
    correct += decision.is_correct ? 1 : 0;
    recalled += decision.is_correct && decision.is_revisit ? 1 : 0;
    const bool is_last_of_score =
        i + 1 == decisions.size() || decisions[i + 1].score < decision.score;
    if (is_last_of_score) {
      sweep.push_back({decision.score,
                       found,
                       correct,
                       1.0 * correct / found,
                       revisits > 0 ? 1.0 * recalled / revisits : 0.0});
    }
  }
  return sweep;
}

SweepPoint PickThreshold(const std::vector<SweepPoint>& sweep, double precision) {
  SweepPoint best;
  best.r = std::numeric_limits<double>::infinity();
  for (const SweepPoint& point : sweep) {
    if (point.precision >= precision && point.recall > best.recall) {
      best = point;
    }
  }
  return best;
}

}  // namespace deja_view
