#pragma once

#include <limits>

namespace deja_view {

/// What to look for. An entry is a candidate when its id is in [min_id, max_id] and its score is at
/// least `min_score` and above 0.
struct PlaceQuery {
  int max_results = 10;
  int min_id = std::numeric_limits<int>::min();
  int max_id = std::numeric_limits<int>::max();
  double min_score = 0;
  /// Only the best entry of each id, of equal ones that of the lowest tag.
  bool best_per_id = false;
};

/// An entry found.
struct PlaceMatch {
  int id = -1;
  int tag = 0;
  double score = 0;

  friend bool operator==(const PlaceMatch& a, const PlaceMatch& b) {
    return a.id == b.id && a.tag == b.tag && a.score == b.score;
  }
};

}  // namespace deja_view
