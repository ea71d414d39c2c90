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

/// log(n) in fixed point; 0 for n = 0, too.
std::int32_t FixedLog(std::uint32_t n);

/// The weight that each word has now (Eq. 9 without the term frequency).
///   frozen   the vocabulary's idf
///   running  log((N + 1) / max(df, 1)): N entries in the database, df of them with the word. The
///   query
///            counts as one of the collection (hence N + 1), so that nothing vanishes when every
///            entry shows a word, least of all with a single entry.
class WordWeights {
 public:
  WordWeights(IdfMode mode, const Vocabulary& vocabulary);

  void Add(const BowVector& bow);     ///< an entry came
  void Remove(const BowVector& bow);  ///< an entry went

  std::int32_t operator[](WordId word) const {
    return mode_ == IdfMode::kFrozen ? weights_[word] : fixed_log_collection_ - FixedLog(df_[word]);
  }

 private:
  IdfMode mode_;
  std::vector<std::int32_t> weights_;  // frozen
  std::vector<std::uint32_t> df_;      // running
  std::uint32_t entries_ = 0;
  std::int32_t fixed_log_collection_ = 0;
};

/// Eq. 11 or Eq. 13 from scratch; the definition that the index must agree with. 0 when a or b has
/// no weight.
double Similarity(ScoreKind kind,
                  const WordWeights& weights,
                  const BowVector& a,
                  const BowVector& b);

}  // namespace deja_view::internal
