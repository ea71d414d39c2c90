#include "deja_view/features/hamming_matcher.hpp"

#include "deja_view/base/check.hpp"

#include "hamming_kernel.hpp"
#include "hamming_keys.hpp"

namespace deja_view {
namespace internal {

void MatchHammingPortable(const HammingProblem& problem) {
  for (std::size_t q = 0; q < problem.query_count; ++q) {
    SmallestKeys keys;
    for (std::size_t i = 0; i < problem.train_count; ++i) {
      keys.Add(ToKey(HammingDistance(problem.queries[q], problem.train[i]), i));
    }
    problem.matches[q] = keys.ToMatch(problem.max_distance);
  }
}

#ifndef DEJA_VIEW_HAVE_HIGHWAY
void MatchHammingVector(const HammingProblem& problem) {
  MatchHammingPortable(problem);
}
#endif

}  // namespace internal

void MatchHamming(const Descriptor* queries,
                  std::size_t query_count,
                  const Descriptor* train,
                  std::size_t train_count,
                  int max_distance,
                  HammingMatch* matches) {
  DEJA_VIEW_CHECK_OP(train_count, <, std::size_t{1} << internal::kIndexBits);
  internal::MatchHammingVector({queries, query_count, train, train_count, max_distance, matches});
}

std::vector<HammingMatch> MatchHamming(const std::vector<Descriptor>& queries,
                                       const std::vector<Descriptor>& train,
                                       int max_distance) {
  std::vector<HammingMatch> matches(queries.size());
  MatchHamming(
      queries.data(), queries.size(), train.data(), train.size(), max_distance, matches.data());
  return matches;
}

}  // namespace deja_view
