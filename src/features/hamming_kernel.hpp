#pragma once

#include "deja_view/features/hamming_match.hpp"
#include "deja_view/features/types.hpp"

#include <cstddef>

namespace deja_view::internal {

/// MatchHamming with the vectors of this CPU; the plain loop in builds without Highway.
void MatchHammingVector(const Descriptor* queries,
                        std::size_t query_count,
                        const Descriptor* train,
                        std::size_t train_count,
                        int max_distance,
                        HammingMatch* matches);

}  // namespace deja_view::internal
