#pragma once

#include "deja_view/features/hamming_match.hpp"
#include "deja_view/features/types.hpp"

#include <cstddef>

namespace deja_view::internal {

/// What MatchHamming is given.
struct HammingProblem {
  const Descriptor* queries;
  std::size_t query_count;
  const Descriptor* train;
  std::size_t train_count;
  int max_distance;
  HammingMatch* matches;
};

/// MatchHamming with the vectors of this CPU; the plain loop in builds without Highway.
void MatchHammingVector(const HammingProblem& problem);

/// The plain loop, which the other is tested against.
void MatchHammingPortable(const HammingProblem& problem);

}  // namespace deja_view::internal
