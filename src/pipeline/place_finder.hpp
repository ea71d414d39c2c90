#pragma once

#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/place/place_database.hpp"
#include "deja_view/place/scored_places.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "candidates.hpp"

namespace deja_view {

/// An image's words, weighted as well where the paper's scoring is on.
struct ImageWords {
  BowVector bow;
  WeightedBow weighted;
};

/// A place by its real image.
struct NewPlace {
  int keyframe = -1;
  int sequence = 0;
  std::int64_t stamp_ns = 0;
  PackedBow words;
};

/// A keyframe whose place is sought.
struct PlaceQuestion {
  int sequence = 0;
  std::int64_t stamp_ns = 0;
  NearbyPlace here;  ///< its own camera
  /// The cameras, real and virtual, of all places whose poses are of the same world.
  std::vector<NearbyPlace> around;
  bool is_localised = false;  ///< `here` is a better guess than what looks alike
};

struct FoundPlaces {
  std::vector<Candidate> candidates;  ///< to be verified in this order
  std::optional<BestPlace> best;
};

/// Knows which past keyframes may show what an image shows: by their words (by L1 score, or as the
/// paper scores them) and by where their cameras are.
class PlaceFinder {
 public:
  /// Throws CheckError for options that are not valid.
  PlaceFinder(const PlaceDatabaseOptions& place,
              const ScoringOptions& scoring,
              const CandidateOptions& candidates,
              std::shared_ptr<const Vocabulary> vocabulary);

  BowVector Bag(const std::vector<Descriptor>& descriptors) const {
    return vocabulary_->Bag(descriptors);
  }
  /// Of all that Words depends on but the descriptors: the vocabulary and the weighting.
  std::uint64_t words_identity() const;
  std::size_t vocabulary_size() const { return vocabulary_->word_count(); }
  bool weighs_words() const { return scored_.has_value(); }
  /// May be called from several threads.
  ImageWords Words(const std::vector<Descriptor>& descriptors) const;
  PackedBow PackedWords(const std::vector<Descriptor>& descriptors) const;

  /// Adds a place by its real image, of which `words` are all Words. Keyframes come in their order:
  /// a lower index is older.
  void Add(int keyframe, int sequence, std::int64_t stamp_ns, const ImageWords& words);
  /// The same as one Add after the other, sooner, on all cores.
  void AddAll(const std::vector<NewPlace>& places);
  /// Adds or takes away a virtual view of a place.
  void AddView(int keyframe, int view, const BowVector& bow);
  void RemoveView(int keyframe, int view);
  void Clear();

  /// Places to verify against the newest keyframe, among those old enough.
  FoundPlaces Find(const PlaceQuestion& question, const ImageWords& words) const;

  /// Tells of a keyframe that has been dealt with: the next one's own score is taken
  /// against the newest few.
  void Pass(ImageWords words);

  /// Score of two images as the place database sees it.
  double Score(const BowVector& a, const BowVector& b) const { return places_.Score(a, b); }

  int size() const { return static_cast<int>(entries_.size()); }
  std::size_t memory_bytes() const;       ///< heap memory of the indices
  std::size_t view_memory_bytes() const;  ///< the views' part of it

 private:
  struct Entry {
    int keyframe = -1;
    int sequence = 0;
    std::int64_t stamp_ns = 0;
  };

  int NewestOldEnough(const PlaceQuestion& question) const;
  RetrievedPlace Retrieved(int keyframe, double score) const;
  std::vector<RetrievedPlace> RetrieveFast(const ImageWords& words,
                                           int newest,
                                           std::optional<BestPlace>* best) const;
  /// Retrieves by the paper's scores. With a threshold r only islands of the nearest few neighbours
  /// that reach it; without, all that a query by L1 would offer, and geometry decides.
  std::vector<RetrievedPlace> RetrieveScored(const ImageWords& words,
                                             int newest,
                                             std::optional<BestPlace>* best) const;
  double OwnScore(const WeightedBow& words) const;
  ImageWords Weighted(BowVector bow) const;
  void Index(int keyframe, const ImageWords& words, int tag);

  PlaceDatabaseOptions place_options_;
  ScoringOptions scoring_;
  CandidateOptions options_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  PlaceDatabase places_;
  std::optional<ScoredPlaces> scored_;    ///< with scoring.is_on; then places_ is empty
  std::vector<Entry> entries_;            ///< the places, the oldest first
  std::deque<WeightedBow> predecessors_;  ///< words of the newest keyframes
  std::size_t empty_bytes_ = 0;           ///< of an index without entries
  std::size_t place_words_ = 0;           ///< indexed for real images,
  std::size_t view_words_ = 0;            ///< and for virtual ones
};

}  // namespace deja_view
