#pragma once

#include "deja_view/features/types.hpp"

#include <vector>

namespace deja_view::internal {

/// sums_i = sum_j k(i, j) values_j and totals_i = sum_j k(i, j), where k is 1 for i = j and else
/// `weights` at the distance [bits] of the two centroids, 0 beyond its end.
struct SynonymSums {
  std::vector<double> sums;
  std::vector<double> totals;
};
using SumSynonymsFunction = SynonymSums (*)(const std::vector<Descriptor>& centroids,
                                            const std::vector<double>& values,
                                            const std::vector<double>& weights);

/// The implementations that this processor can run, the fastest first; all give the same bits.
std::vector<SumSynonymsFunction> AvailableSumSynonyms();

}  // namespace deja_view::internal
