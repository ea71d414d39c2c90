#pragma once

#include "deja_view/features/hamming_match.hpp"
#include "deja_view/features/types.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace deja_view {

/// Compares every query with every train descriptor, in one thread with the widest vectors that the
/// CPU has; the result does not depend on which. Neighbours farther than `max_distance` are left
/// out. One entry per query. Throws CheckError for 2^23 train descriptors or more.
std::vector<HammingMatch> MatchHamming(const std::vector<Descriptor>& queries,
                                       const std::vector<Descriptor>& train,
                                       int max_distance = 256);

/// As above, on memory that the caller holds; `matches` has room for `query_count` entries.
void MatchHamming(const Descriptor* queries,
                  std::size_t query_count,
                  const Descriptor* train,
                  std::size_t train_count,
                  int max_distance,
                  HammingMatch* matches);

}  // namespace deja_view
