#include "deja_view/place/word_scoring.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "synonym_sums.hpp"

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

SynonymKernel::SynonymKernel(std::shared_ptr<const Vocabulary> vocabulary, int radius, double sigma)
    : vocabulary_(std::move(vocabulary)) {
  DEJA_VIEW_CHECK(vocabulary_ != nullptr);
  DEJA_VIEW_CHECK_OP(radius, >=, 0);
  DEJA_VIEW_CHECK_OP(sigma, >, 0.0);
  for (int distance = 0; distance <= radius; ++distance) {
    const double scaled = distance / sigma;
    weights_.push_back(std::exp(-0.5 * scaled * scaled));
  }
}

double SynonymKernel::operator()(WordId a, WordId b) const {
  const auto distance = static_cast<std::size_t>(
      a == b ? 0 : HammingDistance(vocabulary_->Centroid(a), vocabulary_->Centroid(b)));
  return distance < weights_.size() ? weights_[distance] : 0.0;
}

std::vector<double> SynonymKernel::Average(const WeightedBow& bow,
                                           const std::vector<double>& values) const {
  DEJA_VIEW_CHECK_OP(bow.size(), ==, values.size());
  std::vector<Descriptor> centroids;
  centroids.reserve(bow.size());
  for (const WeightedWord& w : bow) {
    centroids.push_back(vocabulary_->Centroid(w.word));
  }
  auto [sums, totals] = internal::AvailableSumSynonyms().front()(centroids, values, weights_);
  for (std::size_t i = 0; i < bow.size(); ++i) {
    sums[i] /= totals[i];
  }
  return std::move(sums);
}

WeightedBow WeighWords(const WeightedBow& tf_idf,
                       WordWeighting weighting,
                       const SynonymKernel* kernel) {
  const double sum = Sum(tf_idf);
  if (weighting == WordWeighting::kTfidf || !(sum > 0)) {
    return tf_idf;
  }
  DEJA_VIEW_CHECK(weighting != WordWeighting::kSynonym || kernel != nullptr);
  std::vector<double> factors;
  for (const WeightedWord& w : tf_idf) {
    const double p = std::min(kMostImportance, w.weight / sum);
    switch (weighting) {
      case WordWeighting::kTfidf:
        factors.push_back(1.0);
        break;
      case WordWeighting::kPrinted:
        factors.push_back((1.0 - p) / (2.0 - p));
        break;
      case WordWeighting::kText:
        factors.push_back(1.0 / (2.0 - p));
        break;
      case WordWeighting::kSynonym:
        factors.push_back(1.0 / (1.0 - p));  // S_bar
        break;
    }
  }
  if (weighting == WordWeighting::kSynonym) {
    factors = kernel->Average(tf_idf, factors);
  }
  WeightedBow weighted = tf_idf;
  for (std::size_t i = 0; i < weighted.size(); ++i) {
    weighted[i].weight *= factors[i];
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
