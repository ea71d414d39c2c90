#include "similarity.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::internal {
namespace {

std::uint64_t Count(const WordCount& entry) {
  return std::min(entry.count, kMaxCount);
}

// Calls f(weight, count in a, count in b) for every word of both.
template <typename F>
void ForEachCommonWord(const WordWeights& weights, const BowVector& a, const BowVector& b, F f) {
  auto i = a.entries.begin();
  auto j = b.entries.begin();
  while (i != a.entries.end() && j != b.entries.end()) {
    if (i->word == j->word) {
      f(static_cast<std::uint64_t>(weights[i->word]), Count(*i), Count(*j));
    }
    const bool is_i_behind = i->word <= j->word;
    const bool is_j_behind = j->word <= i->word;
    i += is_i_behind ? 1 : 0;
    j += is_j_behind ? 1 : 0;
  }
}

}  // namespace

std::int32_t FixedLog(std::uint32_t n) {
  return n < 2 ? 0 : static_cast<std::int32_t>(std::lround(std::log(n) * (1 << kWeightBits)));
}

WordWeights::WordWeights(IdfMode mode, const Vocabulary& vocabulary)
    : mode_(mode), parts_(vocabulary.word_count(), 0) {
  if (mode == IdfMode::kFrozen) {
    for (std::size_t word = 0; word < parts_.size(); ++word) {
      const float idf = vocabulary.Idf(static_cast<WordId>(word));
      parts_[word] = static_cast<std::int32_t>(std::lround(idf * (1 << kWeightBits)));
    }
  }
}

std::uint64_t L1Norm(const WordWeights& weights, const BowVector& bow) {
  std::uint64_t norm = 0;
  for (const WordCount& entry : bow.entries) {
    norm += static_cast<std::uint64_t>(weights[entry.word]) * Count(entry);
  }
  return norm;
}

std::uint64_t SquaredNorm(const WordWeights& weights, const BowVector& bow) {
  std::uint64_t norm = 0;
  for (const WordCount& entry : bow.entries) {
    const std::uint64_t x = static_cast<std::uint64_t>(weights[entry.word]) * Count(entry);
    norm += x * x;
  }
  return norm;
}

std::uint64_t L1Common(const WordWeights& weights,
                       const BowVector& a,
                       std::uint64_t norm_a,
                       const BowVector& b,
                       std::uint64_t norm_b) {
  std::uint64_t sum = 0;
  ForEachCommonWord(weights, a, b, [&](std::uint64_t w, std::uint64_t in_a, std::uint64_t in_b) {
    sum += w * std::min(in_a * norm_b, in_b * norm_a);
  });
  return sum;
}

double CosineScore(std::uint64_t dot, std::uint64_t squared_norm_a, std::uint64_t squared_norm_b) {
  const double scale = std::sqrt(static_cast<double>(squared_norm_a)) *
                       std::sqrt(static_cast<double>(squared_norm_b));
  return scale > 0 ? static_cast<double>(dot) / scale : 0.0;
}

double Similarity(ScoreKind kind,
                  const WordWeights& weights,
                  const BowVector& a,
                  const BowVector& b) {
  if (kind == ScoreKind::kL1) {
    const std::uint64_t norm_a = L1Norm(weights, a);
    const std::uint64_t norm_b = L1Norm(weights, b);
    return L1Score(L1Common(weights, a, norm_a, b, norm_b), norm_a, norm_b);
  }
  std::uint64_t dot = 0;
  ForEachCommonWord(weights, a, b, [&](std::uint64_t w, std::uint64_t in_a, std::uint64_t in_b) {
    dot += w * w * in_a * in_b;
  });
  return CosineScore(dot, SquaredNorm(weights, a), SquaredNorm(weights, b));
}

}  // namespace deja_view::internal
