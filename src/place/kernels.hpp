#pragma once

#include "deja_view/features/types.hpp"

#include <cstdint>
#include <vector>

#include "slot_set.hpp"

namespace deja_view::internal {

/// A bitmap of slots, and what to add to the sum of each.
template <typename Sum>
struct WeightedBitmap {
  const std::uint32_t* bits;
  std::uint32_t words;  ///< a multiple of kBlockWords
  Sum weight;
};

/// sums[slot] += weight for all slots of all bitmaps.
void AddBitmaps(const std::vector<WeightedBitmap<std::uint32_t>>& bitmaps, std::uint32_t* sums);
void AddBitmaps(const std::vector<WeightedBitmap<std::uint64_t>>& bitmaps, std::uint64_t* sums);

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
///            those with a_i = 1, b_i > 2; |a| and |b| already multiplied, modulo 2^64
/// Exact for 2 |b| >= |a|, else an upper bound, because of `more`. All 32-bit numbers are below
/// 2^31.
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
/// at least `threshold`; returns how many. All of them, and hardly any other. `begin` and `end` are
/// multiples of kFilterBlock; the parts have room up to the last one.
std::uint32_t FilterL1(const L1Parts& parts,
                       double threshold,
                       std::uint32_t begin,
                       std::uint32_t end,
                       std::uint32_t* found);

constexpr std::uint32_t kFilterBlock = 8;

/// Doubles round a common sum of up to 62 bits by far less than this.
constexpr double kFilterSlack = 1 - 1e-9;

/// sums_i = sum_j k(i, j) values_j and totals_i = sum_j k(i, j), where k is 1 for i = j and else
/// `weights` at the distance [bits] of the two centroids, 0 beyond its end.
struct SynonymSums {
  std::vector<double> sums;
  std::vector<double> totals;
};

/// Every pair of an image's words is compared. A table of the vocabulary's pairs, made once, is not
/// worth it: of the shipped 79 993 words 4.7 million pairs are within 40 bits (119 per word), 19
/// MB, found in 4.7 s; with it an image of 700 words takes 0.11 ms instead of 0.27 ms (1000 words:
/// 0.14 and 0.53 ms). A vocabulary of a million words would need 3 GB.
SynonymSums SumSynonyms(const std::vector<Descriptor>& centroids,
                        const std::vector<double>& values,
                        const std::vector<double>& weights);

}  // namespace deja_view::internal
