#include "similarity.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::internal {
namespace {

// Calls f(word, count in a, count in b) for every word of either.
template <typename F>
void ForEachWord(const BowVector& a, const BowVector& b, F f) {
  auto i = a.entries.begin();
  auto j = b.entries.begin();
  while (i != a.entries.end() || j != b.entries.end()) {
    if (j == b.entries.end() || (i != a.entries.end() && i->word < j->word)) {
      f(i->word, std::uint64_t{i->count}, std::uint64_t{0});
      ++i;
    } else if (i == a.entries.end() || j->word < i->word) {
      f(j->word, std::uint64_t{0}, std::uint64_t{j->count});
      ++j;
    } else {
      f(i->word, std::uint64_t{i->count}, std::uint64_t{j->count});
      ++i;
      ++j;
    }
  }
}

double L1Similarity(const WordWeights& weights, const BowVector& a, const BowVector& b) {
  std::uint64_t norm_a = 0;
  std::uint64_t norm_b = 0;
  ForEachWord(a, b, [&](WordId word, std::uint64_t in_a, std::uint64_t in_b) {
    norm_a += static_cast<std::uint64_t>(weights[word]) * in_a;
    norm_b += static_cast<std::uint64_t>(weights[word]) * in_b;
  });
  // 1 - 1/2 sum |x - y| = sum min(x, y) when both sum to 1.
  std::uint64_t common = 0;
  ForEachWord(a, b, [&](WordId word, std::uint64_t in_a, std::uint64_t in_b) {
    common += static_cast<std::uint64_t>(weights[word]) * std::min(in_a * norm_b, in_b * norm_a);
  });
  const double scale = static_cast<double>(norm_a) * static_cast<double>(norm_b);
  return scale > 0 ? static_cast<double>(common) / scale : 0.0;
}

double CosineSimilarity(const WordWeights& weights, const BowVector& a, const BowVector& b) {
  std::uint64_t dot = 0;
  std::uint64_t norm_a = 0;
  std::uint64_t norm_b = 0;
  ForEachWord(a, b, [&](WordId word, std::uint64_t in_a, std::uint64_t in_b) {
    const auto w = static_cast<std::uint64_t>(weights[word]);
    dot += w * w * in_a * in_b;
    norm_a += w * w * in_a * in_a;
    norm_b += w * w * in_b * in_b;
  });
  const double scale =
      std::sqrt(static_cast<double>(norm_a)) * std::sqrt(static_cast<double>(norm_b));
  return scale > 0 ? static_cast<double>(dot) / scale : 0.0;
}

}  // namespace

std::int32_t FixedLog(std::uint32_t n) {
  return n < 2 ? 0 : static_cast<std::int32_t>(std::lround(std::log(n) * (1 << kWeightBits)));
}

WordWeights::WordWeights(IdfMode mode, const Vocabulary& vocabulary) : mode_(mode) {
  df_.assign(vocabulary.word_count(), 0);
  weights_.resize(vocabulary.word_count());
  for (std::size_t word = 0; word < weights_.size(); ++word) {
    const float idf = vocabulary.Idf(static_cast<WordId>(word));
    weights_[word] = static_cast<std::int32_t>(std::lround(idf * (1 << kWeightBits)));
  }
}

void WordWeights::Add(const BowVector& bow) {
  fixed_log_collection_ = FixedLog(++entries_ + 1);
  for (const WordCount& entry : bow.entries) {
    ++df_[entry.word];
  }
}

void WordWeights::Remove(const BowVector& bow) {
  fixed_log_collection_ = FixedLog(--entries_ + 1);
  for (const WordCount& entry : bow.entries) {
    --df_[entry.word];
  }
}

double Similarity(ScoreKind kind,
                  const WordWeights& weights,
                  const BowVector& a,
                  const BowVector& b) {
  return kind == ScoreKind::kL1 ? L1Similarity(weights, a, b) : CosineSimilarity(weights, a, b);
}

}  // namespace deja_view::internal
