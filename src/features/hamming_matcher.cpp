#include "deja_view/features/hamming_matcher.hpp"

#include "deja_view/base/check.hpp"

#include "hamming_kernel.hpp"
#include "hamming_keys.hpp"

namespace deja_view {
namespace {

// Inlined into functions that are compiled for different instruction sets.
[[gnu::always_inline]] inline void MatchByPlainLoop(const Descriptor* queries,
                                                    std::size_t query_count,
                                                    const Descriptor* train,
                                                    std::size_t train_count,
                                                    int max_distance,
                                                    HammingMatch* matches) {
  for (std::size_t q = 0; q < query_count; ++q) {
    internal::SmallestKeys keys;
    for (std::size_t i = 0; i < train_count; ++i) {
      int distance = 0;
      for (std::size_t word = 0; word < 4; ++word) {
        distance += __builtin_popcountll(queries[q].words[word] ^ train[i].words[word]);
      }
      keys.Add(internal::ToKey(distance, i));
    }
    matches[q] = keys.ToMatch(max_distance);
  }
}

}  // namespace

namespace internal {

void MatchHammingPortable(const Descriptor* queries,
                          std::size_t query_count,
                          const Descriptor* train,
                          std::size_t train_count,
                          int max_distance,
                          HammingMatch* matches) {
  MatchByPlainLoop(queries, query_count, train, train_count, max_distance, matches);
}

#ifndef DEJA_VIEW_HAVE_HIGHWAY
#ifdef __x86_64__
[[gnu::target("popcnt")]] static void MatchHammingPopcnt(const Descriptor* queries,
                                                         std::size_t query_count,
                                                         const Descriptor* train,
                                                         std::size_t train_count,
                                                         int max_distance,
                                                         HammingMatch* matches) {
  MatchByPlainLoop(queries, query_count, train, train_count, max_distance, matches);
}
#endif

void MatchHammingVector(const Descriptor* queries,
                        std::size_t query_count,
                        const Descriptor* train,
                        std::size_t train_count,
                        int max_distance,
                        HammingMatch* matches) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("popcnt")) {
    MatchHammingPopcnt(queries, query_count, train, train_count, max_distance, matches);
    return;
  }
#endif
  MatchHammingPortable(queries, query_count, train, train_count, max_distance, matches);
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
  internal::MatchHammingVector(queries, query_count, train, train_count, max_distance, matches);
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
