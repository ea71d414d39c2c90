#include "deja_view/fusion/match_samples.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>

namespace deja_view {

MatchSamples::MatchSamples(std::size_t at_most) : at_most_(at_most) {
  DEJA_VIEW_CHECK_OP(at_most, >=, 2U);
}

void MatchSamples::Add(const LoopMatches& matches) {
  Thinned& list = matches.is_virtual ? virtual_ : real_;
  if (list.seen++ % list.stride != 0) {
    return;
  }
  if (list.kept.size() == at_most_) {
    // Every other one goes, so that the rest is as far apart as those to come.
    std::size_t left = 0;
    for (std::size_t i = 0; i < list.kept.size(); i += 2) {
      std::swap(list.kept[left++], list.kept[i]);
    }
    list.kept.resize(left);
    list.stride *= 2;
    if ((list.seen - 1) % list.stride != 0) {
      return;
    }
  }
  list.kept.push_back(matches);
}

std::vector<LoopMatches> MatchSamples::Sorted() const {
  std::vector<LoopMatches> all = real_.kept;
  all.insert(all.end(), virtual_.kept.begin(), virtual_.kept.end());
  std::stable_sort(all.begin(), all.end(), [](const LoopMatches& a, const LoopMatches& b) {
    return a.stamp_current_ns < b.stamp_current_ns;
  });
  return all;
}

}  // namespace deja_view
