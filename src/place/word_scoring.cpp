#include "deja_view/place/word_scoring.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deja_view {
namespace {

constexpr double kMostImportance = 0.999;
constexpr double kLeastOwnScore = 0.05;

/// Calls f(weight in a, weight in b) for every word of either.
template <typename F>
void ForEachWord(const WeightedBow& a, const WeightedBow& b, F f) {
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->word < j->word)) {
      f((i++)->weight, 0.0);
    } else if (i == a.end() || j->word < i->word) {
      f(0.0, (j++)->weight);
    } else {
      f((i++)->weight, (j++)->weight);
    }
  }
}

double Sum(const WeightedBow& bow) {
  double sum = 0;
  for (const WeightedWord& w : bow) {
    sum += w.weight;
  }
  return sum;
}

double Norm(const WeightedBow& bow) {
  double sum = 0;
  for (const WeightedWord& w : bow) {
    sum += w.weight * w.weight;
  }
  return std::sqrt(sum);
}

WeightedBow Scaled(const WeightedBow& bow, double factor) {
  WeightedBow scaled = bow;
  for (WeightedWord& w : scaled) {
    w.weight *= factor;
  }
  return scaled;
}

/// S_bar of a word (Eq. 10).
double Expectation(double weight, double sum) {
  return 1.0 / (1.0 - std::min(kMostImportance, weight / sum));
}

/// Mean of S_bar over the image's words, weighted by their likeness to `word`.
double SynonymFactor(WordId word,
                     const WeightedBow& tf_idf,
                     double sum,
                     const SynonymKernel& kernel) {
  double weighted = 0;
  double total = 0;
  auto in_image = tf_idf.begin();
  for (const auto* synonym = kernel.begin(word); synonym != kernel.end(word); ++synonym) {
    in_image = std::lower_bound(
        in_image, tf_idf.end(), synonym->word, [](const WeightedWord& w, WordId wanted) {
          return w.word < wanted;
        });
    if (in_image != tf_idf.end() && in_image->word == synonym->word) {
      weighted += synonym->weight * Expectation(in_image->weight, sum);
      total += synonym->weight;
    }
  }
  return weighted / total;
}

}  // namespace

WeightedBow TfIdf(const BowVector& bow, const std::function<double(WordId)>& idf) {
  WeightedBow weighted;
  weighted.reserve(bow.entries.size());
  for (const WordCount& entry : bow.entries) {
    weighted.push_back(
        {entry.word, static_cast<double>(entry.count) / bow.descriptor_count * idf(entry.word)});
  }
  return weighted;
}

SynonymKernel::SynonymKernel(const Vocabulary& vocabulary, int radius, double sigma, int threads) {
  DEJA_VIEW_CHECK_OP(radius, >=, 0);
  DEJA_VIEW_CHECK_OP(sigma, >, 0.0);
  const std::size_t words = vocabulary.word_count();
  std::vector<Descriptor> centroids(words);
  for (std::size_t word = 0; word < words; ++word) {
    centroids[word] = vocabulary.Centroid(static_cast<WordId>(word));
  }
  std::vector<std::vector<Synonym>> rows(words);
  ParallelFor(threads, words, [&](std::size_t first, std::size_t last) {
    for (std::size_t a = first; a < last; ++a) {
      for (std::size_t b = 0; b < words; ++b) {
        const int distance = HammingDistance(centroids[a], centroids[b]);
        if (distance <= radius) {
          const double scaled = a == b ? 0.0 : distance / sigma;
          rows[a].push_back({static_cast<WordId>(b), std::exp(-0.5 * scaled * scaled)});
        }
      }
    }
  });
  begin_.reserve(words + 1);
  begin_.push_back(0);
  for (const auto& row : rows) {
    entries_.insert(entries_.end(), row.begin(), row.end());
    begin_.push_back(entries_.size());
  }
}

std::size_t SynonymKernel::memory_bytes() const {
  return begin_.capacity() * sizeof(std::size_t) + entries_.capacity() * sizeof(Synonym);
}

WeightedBow WeighWords(const WeightedBow& tf_idf,
                       WordWeighting weighting,
                       const SynonymKernel* kernel) {
  const double sum = Sum(tf_idf);
  if (weighting == WordWeighting::kTfidf || !(sum > 0)) {
    return tf_idf;
  }
  DEJA_VIEW_CHECK(weighting != WordWeighting::kSynonym || kernel != nullptr);
  WeightedBow weighted = tf_idf;
  for (WeightedWord& w : weighted) {
    const double p = std::min(kMostImportance, w.weight / sum);
    switch (weighting) {
      case WordWeighting::kTfidf:
        break;
      case WordWeighting::kPrinted:
        w.weight *= (1.0 - p) / (2.0 - p);
        break;
      case WordWeighting::kText:
        w.weight /= 2.0 - p;
        break;
      case WordWeighting::kSynonym:
        w.weight *= SynonymFactor(w.word, tf_idf, sum, *kernel);
        break;
    }
  }
  return weighted;
}

double EuclideanDistance(const WeightedBow& a, const WeightedBow& b) {
  double sum = 0;
  ForEachWord(a, b, [&](double x, double y) { sum += (x - y) * (x - y); });
  return std::sqrt(sum);
}

double ManhattanDistance(const WeightedBow& a, const WeightedBow& b) {
  double sum = 0;
  ForEachWord(a, b, [&](double x, double y) { sum += std::abs(x - y); });
  return sum;
}

double L1Similarity(const WeightedBow& a, const WeightedBow& b) {
  const double sum_a = Sum(a);
  const double sum_b = Sum(b);
  if (!(sum_a > 0 && sum_b > 0)) {
    return 0;
  }
  return 1.0 - 0.5 * ManhattanDistance(Scaled(a, 1.0 / sum_a), Scaled(b, 1.0 / sum_b));
}

double L2Similarity(const WeightedBow& a, const WeightedBow& b) {
  const double norm_a = Norm(a);
  const double norm_b = Norm(b);
  if (!(norm_a > 0 && norm_b > 0)) {
    return 0;
  }
  return 1.0 - 0.5 * EuclideanDistance(Scaled(a, 1.0 / norm_a), Scaled(b, 1.0 / norm_b));
}

double CosineSimilarity(const WeightedBow& a, const WeightedBow& b) {
  const double scale = Norm(a) * Norm(b);
  double dot = 0;
  ForEachWord(a, b, [&](double x, double y) { dot += x * y; });
  return scale > 0 ? std::min(1.0, dot / scale) : 0.0;
}

CombinedScore CombineScores(double original, double virtual_view, const DynamicWeights& weights) {
  CombinedScore combined;
  combined.weight_original = 0.5;
  combined.weight_virtual = 0.5;
  if (original > virtual_view) {
    combined.weight_original += weights.alpha * (original - virtual_view);
  } else {
    combined.weight_virtual += weights.beta * (virtual_view - original);
  }
  combined.score = combined.weight_original * original + combined.weight_virtual * virtual_view;
  return combined;
}

double ThresholdScore(const std::vector<double>& island, LoopThreshold threshold, double own) {
  if (island.empty()) {
    return 0;
  }
  if (threshold == LoopThreshold::kSum) {
    return std::accumulate(island.begin(), island.end(), 0.0);
  }
  const double best = *std::max_element(island.begin(), island.end());
  return threshold == LoopThreshold::kPair ? best : best / std::max(kLeastOwnScore, own);
}

}  // namespace deja_view
