#pragma once

#include "deja_view/vocabulary/bow_vector.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::internal {

enum class ScoreKind { kL1, kCosine };
enum class IdfMode { kFrozen, kRunning };

/// Weights are fixed point with this many fractional bits. Integer sums do not depend on the order
/// of their terms, so that an index that is kept up to date bit by bit agrees exactly with a
/// reference that starts from scratch; a resolution of 0.0002 is far finer than an idf means
/// anything.
constexpr int kWeightBits = 12;

/// A word counts at most this often in one image.
constexpr std::uint32_t kMaxCount = 255;

/// Images may have this many descriptors: then sums of weights (below 30) x counts stay below 2^31.
constexpr std::uint32_t kMaxDescriptors = 16384;

/// log(n) in fixed point; 0 for n = 0, too.
std::int32_t FixedLog(std::uint32_t n);

/// The weight that each word has now: TfIdf without the term frequency. Other weightings of words
/// have their place here: they too give each word a number that the scores multiply by.
///   frozen   the vocabulary's idf
///   running  log((N + 1) / max(df, 1)): N entries in the database, df of them with the word. The
///            query counts as one of the collection (hence N + 1), so that nothing vanishes when
///            every entry shows a word, least of all with a single entry.
class WordWeights {
 public:
  WordWeights(IdfMode mode, const Vocabulary& vocabulary);

  IdfMode mode() const { return mode_; }
  std::size_t word_count() const { return parts_.size(); }

  /// >= 0
  std::int32_t operator[](WordId word) const {
    return mode_ == IdfMode::kFrozen ? parts_[word] : log_collection_ - parts_[word];
  }

  /// Running only: log(N + 1), and log(max(df, 1)) of a word. A weight is their difference.
  std::int32_t log_collection() const { return log_collection_; }
  std::int32_t log_df(WordId word) const { return parts_[word]; }

  /// Running only: the database holds `entries` now, `df` of them with `word`.
  void SetEntries(std::uint32_t entries) { log_collection_ = FixedLog(entries + 1); }
  void SetDf(WordId word, std::uint32_t df) { parts_[word] = FixedLog(df); }

  std::size_t memory_bytes() const { return parts_.capacity() * sizeof(std::int32_t); }

 private:
  IdfMode mode_;
  std::vector<std::int32_t> parts_;  // weights (frozen) or log df (running)
  std::int32_t log_collection_ = 0;
};

/// sum_i w_i c_i, and sum_i (w_i c_i)^2.
std::uint64_t L1Norm(const WordWeights& weights, const BowVector& bow);
std::uint64_t SquaredNorm(const WordWeights& weights, const BowVector& bow);

/// sum_i w_i min(a_i |b|, b_i |a|)
std::uint64_t L1Common(const WordWeights& weights,
                       const BowVector& a,
                       std::uint64_t norm_a,
                       const BowVector& b,
                       std::uint64_t norm_b);

/// From norms and sum_i w_i min(a_i |b|, b_i |a|): 1 - 1/2 sum |x - y|, with the Manhattan distance
/// (Eq. 12), is sum min(x, y) when both sum to 1. 0 when a norm is.
inline double L1Score(std::uint64_t common, std::uint64_t norm_a, std::uint64_t norm_b) {
  const double scale = static_cast<double>(norm_a) * static_cast<double>(norm_b);
  return scale > 0 ? static_cast<double>(common) / scale : 0.0;
}

/// From squared norms and the scalar product; unit vectors are sqrt(2 - 2 cosine) apart by
/// Euclidean distance (Eq. 11), which orders places alike. 0 when a norm is.
double CosineScore(std::uint64_t dot, std::uint64_t squared_norm_a, std::uint64_t squared_norm_b);

/// Either score from scratch: the definition that the index agrees with bit for bit.
double Similarity(ScoreKind kind,
                  const WordWeights& weights,
                  const BowVector& a,
                  const BowVector& b);

}  // namespace deja_view::internal
