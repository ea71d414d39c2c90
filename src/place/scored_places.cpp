#include "deja_view/place/scored_places.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "top_k.hpp"
#include "weighted_index.hpp"

namespace deja_view {

std::vector<std::string> ScoringOptions::Validate() const {
  Requirements require;
  require.That(alpha >= 0, "alpha must not be negative");
  require.That(beta >= 0, "beta must not be negative");
  require.That(r >= 0, "r must not be negative");
  require.That(neighbours >= 1, "neighbours must be at least 1");
  require.That(synonym_radius >= 0 && synonym_radius <= 128, "synonym_radius must be in 0..128");
  require.That(synonym_sigma > 0, "synonym_sigma must be positive");
  return require.errors();
}

namespace {

struct IsBetter {
  bool operator()(const ScoredPlace& a, const ScoredPlace& b) const {
    return a.score != b.score ? a.score > b.score : a.id < b.id;
  }
};

/// Slots by the bounds of their scores.
struct Bound {
  float most = 0;
  std::uint32_t slot = 0;
};
struct IsLarger {
  bool operator()(const Bound& a, const Bound& b) const {
    return a.most != b.most ? a.most > b.most : a.slot > b.slot;
  }
};

constexpr float kNoView = -1;

}  // namespace

class ScoredPlaces::Impl {
 public:
  Impl(const ScoringOptions& options, std::shared_ptr<const Vocabulary> vocabulary);

  void Add(int id, const BowVector& bow, const WeightedBow& weighted, int tag) {
    Own(id, tag, index_.Add(Pack(bow, weighted)));
  }
  void AddAll(const std::vector<WeighedImage>& images, int tag);
  void Remove(int id, int tag);
  void Clear();
  WeightedBow Weigh(const BowVector& bow) const;
  std::vector<ScoredPlace> Query(const WeightedBow& query, int max_id, std::size_t count) const;
  std::size_t memory_bytes() const;

 private:
  struct Image {
    int tag = 0;
    std::uint32_t slot = 0;
  };
  struct Place {
    int id = -1;
    std::vector<Image> images;
  };

  void Own(int id, int tag, std::uint32_t slot);
  double Combined(double original, double view) const;
  double MostScore(float cosine) const;
  std::vector<std::uint32_t> LargestOf(const std::vector<float>& bounds,
                                       int max_id,
                                       std::size_t count) const;
  ScoredPlace Score(const Place& place, const std::vector<float>& query) const;

  ScoringOptions options_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::shared_ptr<const SynonymKernel> kernel_;
  internal::WeightedIndex index_;
  std::vector<std::uint32_t> owners_;  ///< indices in places_, of the index's slots
  std::vector<Place> places_;
  std::map<int, std::uint32_t> place_of_;  ///< index in places_ of an id
  bool has_views_ = false;
};

ScoredPlaces::Impl::Impl(const ScoringOptions& options,
                         std::shared_ptr<const Vocabulary> vocabulary)
    : options_(options), vocabulary_(std::move(vocabulary)), index_(vocabulary_) {
  if (options_.weights == WordWeighting::kSynonym) {
    kernel_ = std::make_shared<SynonymKernel>(
        vocabulary_, options_.synonym_radius, options_.synonym_sigma);
  }
}

WeightedBow ScoredPlaces::Impl::Weigh(const BowVector& bow) const {
  WeightedBow words =
      WeighWords(TfIdf(bow, [this](WordId word) { return double{vocabulary_->Idf(word)}; }),
                 options_.weights,
                 kernel_.get());
  double squares = 0;
  for (const WeightedWord& w : words) {
    squares += w.weight * w.weight;
  }
  for (WeightedWord& w : words) {
    w.weight = squares > 0 ? w.weight / std::sqrt(squares) : 0.0;
  }
  return words;
}

void ScoredPlaces::Impl::AddAll(const std::vector<WeighedImage>& images, int tag) {
  std::vector<const PackedBow*> words;
  words.reserve(images.size());
  for (const WeighedImage& image : images) {
    words.push_back(image.words);
  }
  const std::vector<std::uint32_t> slots = index_.AddAll(words);
  for (std::size_t i = 0; i < images.size(); ++i) {
    Own(images[i].id, tag, slots[i]);
  }
}

void ScoredPlaces::Impl::Own(int id, int tag, std::uint32_t slot) {
  const auto [found, is_new] =
      place_of_.try_emplace(id, static_cast<std::uint32_t>(places_.size()));
  if (is_new) {
    places_.push_back({id, {}});
  }
  owners_.resize(index_.slot_count());
  owners_[slot] = found->second;
  has_views_ |= tag != 0;
  places_[found->second].images.push_back({tag, slot});
}

void ScoredPlaces::Impl::Remove(int id, int tag) {
  const auto place = place_of_.find(id);
  if (place == place_of_.end()) {
    return;
  }
  std::vector<Image>& images = places_[place->second].images;
  const auto image = std::find_if(
      images.begin(), images.end(), [tag](const Image& other) { return other.tag == tag; });
  if (image != images.end()) {
    index_.Remove(image->slot);
    images.erase(image);
  }
}

void ScoredPlaces::Impl::Clear() {
  index_.Clear();
  owners_.clear();
  places_.clear();
  place_of_.clear();
  has_views_ = false;
}

double ScoredPlaces::Impl::Combined(double original, double view) const {
  return CombineScores(original, view, {options_.alpha, options_.beta}).score;
}

// The combined score is convex in either cosine, so that the largest of all up to `cosine` is at a
// corner. (It may fall when a view gets more alike.)
double ScoredPlaces::Impl::MostScore(float cosine) const {
  constexpr double kRounding = 1.000001;
  const auto c = static_cast<double>(std::min(1.0F, cosine));
  return kRounding * (has_views_ ? std::max({Combined(c, c), Combined(c, 0), Combined(0, c)}) : c);
}

// The slots of the `count` largest bounds above 0, of places that are asked for.
std::vector<std::uint32_t> ScoredPlaces::Impl::LargestOf(const std::vector<float>& bounds,
                                                         int max_id,
                                                         std::size_t count) const {
  internal::TopK<Bound, IsLarger> best(count);
  float threshold = 0;
  for (std::uint32_t slot = 0; slot < bounds.size(); ++slot) {
    if (bounds[slot] > threshold && places_[owners_[slot]].id <= max_id) {
      best.Offer({bounds[slot], slot});
      threshold = best.is_full() ? best.worst().most : 0.0F;
    }
  }
  std::vector<std::uint32_t> largest;
  for (const Bound& bound : best.Take()) {
    largest.push_back(bound.slot);
  }
  return largest;
}

ScoredPlace ScoredPlaces::Impl::Score(const Place& place, const std::vector<float>& query) const {
  float original = 0;
  float best_view = kNoView;
  for (const Image& image : place.images) {
    const float cosine = std::min(1.0F, index_.Dot(image.slot, query));
    if (image.tag == 0) {
      original = cosine;
    } else {
      best_view = std::max(best_view, cosine);
    }
  }
  const auto o = static_cast<double>(original);
  const double v = best_view == kNoView ? o : static_cast<double>(best_view);
  return {place.id, o, v, Combined(o, v)};
}

std::vector<ScoredPlace> ScoredPlaces::Impl::Query(const WeightedBow& query,
                                                   int max_id,
                                                   std::size_t count) const {
  if (count == 0) {
    return {};
  }
  const std::vector<float> bounds = index_.Bounds(query);
  const std::vector<float> weights = index_.Spread(query);
  internal::TopK<ScoredPlace, IsBetter> best(count);
  std::vector<bool> is_scored(places_.size());
  const auto offer = [&](std::uint32_t slot) {
    const Place& place = places_[owners_[slot]];
    if (place.id <= max_id && !is_scored[owners_[slot]]) {
      is_scored[owners_[slot]] = true;
      const ScoredPlace scored = Score(place, weights);
      if (std::max(scored.original, scored.virtual_view) > 0) {
        best.Offer(scored);
      }
    }
  };
  // These raise the threshold so far that hardly any other place is left to be scored.
  for (const std::uint32_t slot : LargestOf(bounds, max_id, count)) {
    offer(slot);
  }
  for (std::uint32_t slot = 0; slot < bounds.size(); ++slot) {
    const double threshold = best.is_full() ? best.worst().score : 0.0;
    if (bounds[slot] > 0 && MostScore(bounds[slot]) >= threshold) {
      offer(slot);
    }
  }
  return best.Take();
}

std::size_t ScoredPlaces::Impl::memory_bytes() const {
  constexpr std::size_t kMapNode = 48;
  std::size_t bytes = index_.memory_bytes() + owners_.capacity() * sizeof(std::uint32_t) +
                      places_.capacity() * sizeof(Place) + place_of_.size() * kMapNode;
  for (const Place& place : places_) {
    bytes += place.images.capacity() * sizeof(Image);
  }
  return bytes;
}

ScoredPlaces::ScoredPlaces(const ScoringOptions& options,
                           std::shared_ptr<const Vocabulary> vocabulary)
    : impl_(std::make_unique<Impl>(options, std::move(vocabulary))) {}

ScoredPlaces::~ScoredPlaces() = default;
ScoredPlaces::ScoredPlaces(ScoredPlaces&&) noexcept = default;
ScoredPlaces& ScoredPlaces::operator=(ScoredPlaces&&) noexcept = default;

void ScoredPlaces::Add(int id, const BowVector& bow, int tag) {
  impl_->Add(id, bow, impl_->Weigh(bow), tag);
}

void ScoredPlaces::Add(int id, const BowVector& bow, const WeightedBow& weighted, int tag) {
  impl_->Add(id, bow, weighted, tag);
}

void ScoredPlaces::AddAll(const std::vector<WeighedImage>& images, int tag) {
  impl_->AddAll(images, tag);
}

void ScoredPlaces::Remove(int id, int tag) {
  impl_->Remove(id, tag);
}

void ScoredPlaces::Clear() {
  impl_->Clear();
}

WeightedBow ScoredPlaces::Weigh(const BowVector& bow) const {
  return impl_->Weigh(bow);
}

std::vector<ScoredPlace> ScoredPlaces::Query(const WeightedBow& query,
                                             int max_id,
                                             std::size_t count) const {
  return impl_->Query(query, max_id, count);
}

std::size_t ScoredPlaces::memory_bytes() const {
  return impl_->memory_bytes();
}

}  // namespace deja_view
