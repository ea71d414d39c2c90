#pragma once

#include <cstdint>
#include <vector>

namespace deja_view::internal {

/// Sums over the words that the query a and each slot b share, whose parts make up
/// sum_i w_i min(a_i |b|, b_i |a|).
///
/// a_i and b_i are nearly always 1, and |a| and |b| nearly equal, so nearly every word adds
/// w min(|a|, |b|). To add only a constant per slot and word, the sums are kept in parts, with |a|
/// and |b| multiplied at the end:
///   once     sum of w, words with a_i = 1                    x min(|a|, |b|)
///   more     sum of w, words with a_i > 1                    x |a|
///   repeats  sum of w, words with a_i = 1, b_i > 1           x min(|b|, 2 |a|) - min(|b|, |a|)
///   rest     what these leave out of the words with a_i > 1 and b_i > 1, and, for |b| > 2 |a|, of
///   those
///            with a_i = 1, b_i > 2; |a| and |b| already multiplied, modulo 2^64
/// Exact for 2 |b| >= |a|, else an upper bound, because of `more`.
struct L1Parts {
  std::uint64_t norm = 0;                ///< |a|
  const std::uint32_t* norms = nullptr;  ///< |b| of each slot
  const std::uint32_t* once = nullptr;
  const std::uint32_t* more = nullptr;
  const std::uint32_t* repeats = nullptr;
  const std::uint64_t* rest = nullptr;

  bool IsExact(std::uint32_t slot) const { return 2 * std::uint64_t{norms[slot]} >= norm; }

  std::uint64_t Common(std::uint32_t slot) const {
    const std::uint64_t b = norms[slot];
    const std::uint64_t least = b < norm ? b : norm;
    const std::uint64_t least_twice = b < 2 * norm ? b : 2 * norm;
    return once[slot] * least + more[slot] * norm + repeats[slot] * (least_twice - least) +
           rest[slot];
  }
};

/// Writes those slots of [begin, end) to `found` whose common sum is not 0 and may give a score of
/// at least `threshold`; returns how many. All of them, and hardly any other.
using L1FilterFunction = std::uint32_t (*)(const L1Parts& parts,
                                           double threshold,
                                           std::uint32_t begin,
                                           std::uint32_t end,
                                           std::uint32_t* found);

struct L1FilterKernel {
  const char* name;
  L1FilterFunction filter;
};

/// The implementations that this processor can run, the fastest first.
std::vector<L1FilterKernel> AvailableL1FilterKernels();

/// `begin` and `end` are multiples of this; the parts have room up to the last one.
constexpr std::uint32_t kFilterBlock = 8;

}  // namespace deja_view::internal
