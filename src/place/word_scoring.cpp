#include "deja_view/place/word_scoring.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels.hpp"

namespace deja_view {
namespace {

constexpr double kMostImportance = 0.999;
constexpr double kLeastOwnScore = 0.05;

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

}  // namespace

// Eq. 9.
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
  auto [sums, totals] = internal::SumSynonyms(centroids, values, weights_);
  for (std::size_t i = 0; i < bow.size(); ++i) {
    sums[i] /= totals[i];
  }
  return std::move(sums);
}

// Eq. 8, with S_bar by Eq. 10.
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

// Eq. 13.
double CosineSimilarity(const WeightedBow& a, const WeightedBow& b) {
  const double scale = Norm(a) * Norm(b);
  double dot = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->word == j->word) {
      dot += (i++)->weight * (j++)->weight;
    } else {
      ++(i->word < j->word ? i : j);
    }
  }
  return scale > 0 ? std::min(1.0, dot / scale) : 0.0;
}

CombinedScore CombineScores(double original, double virtual_view, const DynamicWeights& weights) {
  CombinedScore combined;
  combined.weight_original = 0.5;  // Eq. 14
  combined.weight_virtual = 0.5;
  if (original > virtual_view) {  // Eq. 15
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
