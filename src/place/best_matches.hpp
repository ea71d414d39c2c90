#pragma once

#include "deja_view/place/place_database.hpp"

#include <algorithm>
#include <vector>

namespace deja_view::internal {

/// Keeps the best of the matches offered.
class BestMatches {
 public:
  explicit BestMatches(const PlaceQuery& query)
      : limit_(static_cast<std::size_t>(std::max(0, query.max_results))),
        min_score_(query.min_score),
        best_per_id_(query.best_per_id) {}

  /// A score below this can't enter any more.
  double threshold() const {
    return limit_ > 0 && heap_.size() == limit_ ? std::max(min_score_, heap_.front().score)
                                                : min_score_;
  }

  void Offer(const PlaceMatch& match) {
    if (limit_ == 0 || match.score < min_score_ || !(match.score > 0)) {
      return;
    }
    if (best_per_id_ && ReplaceSameId(match)) {
      return;
    }
    if (heap_.size() == limit_) {
      if (!IsBetter(match, heap_.front())) {
        return;
      }
      std::pop_heap(heap_.begin(), heap_.end(), &IsBetter);
      heap_.pop_back();
    }
    heap_.push_back(match);
    std::push_heap(heap_.begin(), heap_.end(), &IsBetter);
  }

  /// Best first.
  std::vector<PlaceMatch> Take() {
    std::sort_heap(heap_.begin(), heap_.end(), &IsBetter);
    return std::move(heap_);
  }

 private:
  // True when an entry of the match's id is kept, from now on the better of the two.
  bool ReplaceSameId(const PlaceMatch& match) {
    const auto same = std::find_if(
        heap_.begin(), heap_.end(), [&](const PlaceMatch& kept) { return kept.id == match.id; });
    if (same == heap_.end()) {
      return false;
    }
    if (IsBetter(match, *same)) {
      *same = match;
      std::make_heap(heap_.begin(), heap_.end(), &IsBetter);
    }
    return true;
  }

  static bool IsBetter(const PlaceMatch& a, const PlaceMatch& b) {
    if (a.score != b.score) {
      return a.score > b.score;
    }
    return a.id != b.id ? a.id < b.id : a.tag < b.tag;
  }

  std::size_t limit_;
  double min_score_;
  bool best_per_id_;
  std::vector<PlaceMatch> heap_;  // the worst in front
};

}  // namespace deja_view::internal
