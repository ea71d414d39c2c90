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
        min_score_(query.min_score) {}

  /// A score below this can't enter any more.
  double threshold() const {
    return limit_ > 0 && heap_.size() == limit_ ? std::max(min_score_, heap_.front().score)
                                                : min_score_;
  }

  void Offer(const PlaceMatch& match) {
    if (limit_ == 0 || match.score < min_score_ || !(match.score > 0)) {
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
  static bool IsBetter(const PlaceMatch& a, const PlaceMatch& b) {
    if (a.score != b.score) {
      return a.score > b.score;
    }
    return a.id != b.id ? a.id < b.id : a.tag < b.tag;
  }

  std::size_t limit_;
  double min_score_;
  std::vector<PlaceMatch> heap_;  // the worst in front
};

}  // namespace deja_view::internal
