#pragma once

#include "deja_view/features/hamming_matcher.hpp"

namespace deja_view::internal {

/// MatchHamming with the vectors of this CPU; the plain loop in builds without Highway.
void MatchHammingVector(const HammingProblem& problem);

}  // namespace deja_view::internal
