// Compiled once per instruction set; Highway picks the best at run time.
#include "hamming_kernel.hpp"

#include <cstdint>
#include <vector>

#include "hamming_keys.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "hamming_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace deja_view::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

// No vectors: the plain loop.
void MatchHammingTarget(const HammingProblem& problem) {
  MatchHammingPortable(problem);
}

#else

// Word w of `lanes` consecutive descriptors side by side, block after block, so that the bit counts
// of a descriptor's four words are summed without crossing lanes.
std::vector<std::uint64_t> Interleave(const Descriptor* train,
                                      std::size_t blocks,
                                      std::size_t lanes) {
  std::vector<std::uint64_t> planes(blocks * lanes * 4);
  for (std::size_t block = 0; block < blocks; ++block) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      for (std::size_t word = 0; word < 4; ++word) {
        planes[(block * 4 + word) * lanes + lane] = train[block * lanes + lane].words[word];
      }
    }
  }
  return planes;
}

SmallestKeys SearchBlocks(const Descriptor& query,
                          const std::vector<std::uint64_t>& planes,
                          std::size_t blocks) {
  const hn::ScalableTag<std::uint64_t> d64;
  const hn::Repartition<std::uint8_t, decltype(d64)> d8;
  const hn::Repartition<std::uint32_t, decltype(d64)> d32;
  const std::size_t lanes = hn::Lanes(d64);
  const auto q0 = hn::Set(d64, query.words[0]);
  const auto q1 = hn::Set(d64, query.words[1]);
  const auto q2 = hn::Set(d64, query.words[2]);
  const auto q3 = hn::Set(d64, query.words[3]);
  const auto count = [&](auto q, const std::uint64_t* words) {
    return hn::PopulationCount(hn::BitCast(d8, hn::Xor(q, hn::LoadU(d64, words))));
  };
  // The keys are the low halves of 64-bit lanes: every instruction set has 32-bit minima.
  auto best = hn::Set(d32, kNoKey);
  auto second = best;
  auto index = hn::Iota(d64, 0);
  const auto step = hn::Set(d64, lanes);
  const std::uint64_t* words = planes.data();
  for (std::size_t block = 0; block < blocks; ++block, words += 4 * lanes) {
    // At most 8 per byte and word, 32 in all: no overflow before the bytes are summed.
    const auto bytes = hn::Add(hn::Add(count(q0, words), count(q1, words + lanes)),
                               hn::Add(count(q2, words + 2 * lanes), count(q3, words + 3 * lanes)));
    const auto distance = hn::SumsOf8(bytes);
    const auto key = hn::BitCast(d32, hn::Or(hn::ShiftLeft<kIndexBits>(distance), index));
    second = hn::Min(second, hn::Max(best, key));
    best = hn::Min(best, key);
    index = hn::Add(index, step);
  }
  std::vector<std::uint64_t> best_lanes(lanes);
  std::vector<std::uint64_t> second_lanes(lanes);
  hn::StoreU(hn::BitCast(d64, best), d64, best_lanes.data());
  hn::StoreU(hn::BitCast(d64, second), d64, second_lanes.data());
  SmallestKeys keys;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    keys.Add(static_cast<std::uint32_t>(best_lanes[lane]));
    keys.Add(static_cast<std::uint32_t>(second_lanes[lane]));
  }
  return keys;
}

void MatchHammingTarget(const HammingProblem& problem) {
  const std::size_t lanes = hn::Lanes(hn::ScalableTag<std::uint64_t>());
  const std::size_t blocks = problem.train_count / lanes;
  const std::vector<std::uint64_t> planes = Interleave(problem.train, blocks, lanes);
  for (std::size_t q = 0; q < problem.query_count; ++q) {
    const Descriptor& query = problem.queries[q];
    SmallestKeys keys = SearchBlocks(query, planes, blocks);
    for (std::size_t i = blocks * lanes; i < problem.train_count; ++i) {
      keys.Add(ToKey(HammingDistance(query, problem.train[i]), i));
    }
    problem.matches[q] = keys.ToMatch(problem.max_distance);
  }
}

#endif

}  // namespace deja_view::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace deja_view::internal {

HWY_EXPORT(MatchHammingTarget);

void MatchHammingVector(const HammingProblem& problem) {
  HWY_DYNAMIC_DISPATCH(MatchHammingTarget)
  (problem);
}

}  // namespace deja_view::internal
#endif
