#pragma once

#include <cstdint>

namespace deja_view {

/// The two nearest train descriptors of one query. An index is -1, and its distance 257, where
/// there is none. Of equal distances the lower index comes first.
struct HammingMatch {
  std::int32_t best = -1;
  std::int32_t best_distance = 257;  ///< [bit]
  std::int32_t second = -1;
  std::int32_t second_distance = 257;  ///< [bit], >= best_distance

  friend bool operator==(const HammingMatch& a, const HammingMatch& b) {
    return a.best == b.best && a.best_distance == b.best_distance && a.second == b.second &&
           a.second_distance == b.second_distance;
  }
};

}  // namespace deja_view
