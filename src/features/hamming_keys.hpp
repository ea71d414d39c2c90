#pragma once

#include "deja_view/features/hamming_match.hpp"

#include <algorithm>
#include <cstdint>

namespace deja_view::internal {

/// A key holds distance and index, so that the smaller key is the nearer descriptor and, of equally
/// near ones, that of the lower index. Keys of one query are all different.
constexpr int kIndexBits = 23;
constexpr std::uint32_t kNoKey = 0xFFFFFFFFU;

/// The two smallest keys seen.
struct SmallestKeys {
  std::uint32_t best = kNoKey;
  std::uint32_t second = kNoKey;

  void Add(std::uint32_t key) {
    second = std::min(second, std::max(best, key));
    best = std::min(best, key);
  }

  HammingMatch ToMatch(int max_distance) const {
    HammingMatch match;
    Unpack(best, max_distance, &match.best, &match.best_distance);
    Unpack(second, max_distance, &match.second, &match.second_distance);
    return match;
  }

 private:
  static void Unpack(std::uint32_t key,
                     int max_distance,
                     std::int32_t* index,
                     std::int32_t* distance) {
    const auto found = static_cast<std::int32_t>(key >> kIndexBits);
    if (key != kNoKey && found <= max_distance) {
      *index = static_cast<std::int32_t>(key & ((1U << kIndexBits) - 1));
      *distance = found;
    }
  }
};

inline std::uint32_t ToKey(int distance, std::size_t index) {
  return static_cast<std::uint32_t>(distance) << kIndexBits | static_cast<std::uint32_t>(index);
}

}  // namespace deja_view::internal
