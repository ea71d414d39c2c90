#pragma once

#include "deja_view/place/packed_bow.hpp"
#include "deja_view/place/word_scoring.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// The paper's scoring of past places; off, the place database's own score (L1) is used.
struct ScoringOptions {
  bool is_on = true;
  WordWeighting weights = WordWeighting::kSynonym;
  double alpha = 1.0;  ///< what the original image's weight gains with its lead
  double beta = 0.5;   ///< the same for the virtual image
  LoopThreshold threshold = LoopThreshold::kCalibrated;
  double r = 0.0;           ///< an island must reach; 0: all do. See LoopThreshold for the ranges
  int neighbours = 4;       ///< keyframes retrieved, whose scores an island sums (VINS-Mono: 4)
  int synonym_radius = 40;  ///< [bits] between the centroids of synonyms
  double synonym_sigma = 20.0;  ///< [bits] of their kernel

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("is_on", is_on);
    v("weights", weights);
    v("alpha", alpha);
    v("beta", beta);
    v("threshold", threshold);
    v("r", r);
    v("neighbours", neighbours);
    v("synonym_radius", synonym_radius);
    v("synonym_sigma", synonym_sigma);
  }
};

/// A past keyframe and its scores against a query.
struct ScoredPlace {
  int id = -1;
  double original = 0;      ///< cosine with the original image
  double virtual_view = 0;  ///< best cosine with a virtual image; the original's without any
  double score = 0;         ///< combined (CombineScores)
};

/// A keyframe's words, packed with the weights that Weigh gives for them.
struct WeighedImage {
  int id = -1;
  const PackedBow* words = nullptr;
};

/// Weighted words of past keyframes, scored as the paper does. Weights are those of the
/// vocabulary's idf, computed once when a place is added. Deterministic; const methods may be
/// called from several threads.
class ScoredPlaces {
 public:
  /// Makes the vocabulary's SynonymKernel when the weights need it.
  ScoredPlaces(const ScoringOptions& options, std::shared_ptr<const Vocabulary> vocabulary);
  ~ScoredPlaces();
  ScoredPlaces(ScoredPlaces&& other) noexcept;
  ScoredPlaces& operator=(ScoredPlaces&& other) noexcept;

  /// `tag` 0: the original image, else a virtual one. (id, tag) must be new.
  void Add(int id, const BowVector& bow, int tag);
  /// The same with `weighted`, what Weigh gives for `bow`.
  void Add(int id, const BowVector& bow, const WeightedBow& weighted, int tag);
  /// The same as one Add after the other, sooner, on all cores.
  void AddAll(const std::vector<WeighedImage>& images, int tag);
  void Remove(int id, int tag);
  void Clear();

  WeightedBow Weigh(const BowVector& bow) const;

  /// The best `count` places with an id of at most `max_id` and a score above 0, best first; ties
  /// go to the lower id. Exact: bit for bit what scoring every place gives. `query` is of length 1,
  /// as Weigh returns it.
  std::vector<ScoredPlace> Query(const WeightedBow& query, int max_id, std::size_t count) const;

  std::size_t memory_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deja_view
