#pragma once

#include "deja_view/place/place_database.hpp"

#include <algorithm>
#include <vector>

#include "top_k.hpp"

namespace deja_view::internal {

/// Keeps the best of the matches offered.
class BestMatches {
 public:
  explicit BestMatches(const PlaceQuery& query)
      : best_(static_cast<std::size_t>(std::max(0, query.max_results))),
        is_empty_(query.max_results <= 0),
        min_score_(query.min_score),
        best_per_id_(query.best_per_id) {}

  /// A score below this can't enter any more.
  double threshold() const {
    return !is_empty_ && best_.is_full() ? std::max(min_score_, best_.worst().score) : min_score_;
  }

  void Offer(const PlaceMatch& match) {
    if (is_empty_ || match.score < min_score_ || !(match.score > 0)) {
      return;
    }
    const auto is_same = [&](const PlaceMatch& kept) { return kept.id == match.id; };
    if (!best_per_id_ || !best_.Improve(match, is_same)) {
      best_.Offer(match);
    }
  }

  /// Best first.
  std::vector<PlaceMatch> Take() { return best_.Take(); }

 private:
  struct IsBetter {
    bool operator()(const PlaceMatch& a, const PlaceMatch& b) const {
      if (a.score != b.score) {
        return a.score > b.score;
      }
      return a.id != b.id ? a.id < b.id : a.tag < b.tag;
    }
  };

  TopK<PlaceMatch, IsBetter> best_;
  bool is_empty_;
  double min_score_;
  bool best_per_id_;
};

}  // namespace deja_view::internal
