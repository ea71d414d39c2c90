#include "deja_view/place/scored_places.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

ScoredPlaces::ScoredPlaces(const ScoringOptions& options,
                           std::shared_ptr<const Vocabulary> vocabulary)
    : options_(options), vocabulary_(std::move(vocabulary)), postings_(vocabulary_->word_count()) {
  if (options_.weights == WordWeighting::kSynonym) {
    kernel_ = std::make_shared<SynonymKernel>(
        vocabulary_, options_.synonym_radius, options_.synonym_sigma);
  }
}

WeightedBow ScoredPlaces::Weigh(const BowVector& bow) const {
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

void ScoredPlaces::Add(int id, const BowVector& bow, int tag) {
  const auto [place, is_new] = place_of_.try_emplace(id, static_cast<int>(ids_.size()));
  if (is_new) {
    ids_.push_back(id);
  }
  const auto entry = static_cast<std::uint32_t>(entries_.size());
  for (const WeightedWord& w : Weigh(bow)) {
    postings_.at(w.word).push_back({entry, static_cast<float>(w.weight)});
  }
  entries_.push_back({place->second, tag});
}

void ScoredPlaces::Remove(int id, int tag) {
  const auto place = place_of_.find(id);
  for (Entry& entry : entries_) {
    if (place != place_of_.end() && entry.place == place->second && entry.tag == tag) {
      entry.place = kRemoved;
    }
  }
}

void ScoredPlaces::Clear() {
  entries_.clear();
  ids_.clear();
  place_of_.clear();
  postings_.assign(postings_.size(), {});
}

// Per place the cosines of its original image (0 without) and of its best view (-1 without).
std::vector<ScoredPlaces::Cosines> ScoredPlaces::CosinesWith(const WeightedBow& query) const {
  std::vector<float> of_entry(entries_.size(), 0.0F);
  for (const WeightedWord& w : query) {
    const auto weight = static_cast<float>(w.weight);
    for (const Posting& posting : postings_.at(w.word)) {
      of_entry[posting.entry] += weight * posting.weight;
    }
  }
  std::vector<Cosines> of_place(ids_.size());
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].place == kRemoved) {
      continue;
    }
    Cosines& place = of_place[static_cast<std::size_t>(entries_[i].place)];
    const float cosine = std::min(1.0F, of_entry[i]);
    if (entries_[i].tag == 0) {
      place.original = cosine;
    } else {
      place.best_view = std::max(place.best_view, cosine);
    }
  }
  return of_place;
}

std::vector<ScoredPlace> ScoredPlaces::Query(const WeightedBow& query,
                                             int max_id,
                                             std::size_t count) const {
  const std::vector<Cosines> cosines = CosinesWith(query);
  std::vector<ScoredPlace> places;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const double original = static_cast<double>(cosines[i].original);
    const double view =
        cosines[i].best_view < 0 ? original : static_cast<double>(cosines[i].best_view);
    if (ids_[i] <= max_id && std::max(original, view) > 0) {
      const double score = CombineScores(original, view, {options_.alpha, options_.beta}).score;
      places.push_back({ids_[i], original, view, score});
    }
  }
  const std::size_t kept = std::min(places.size(), count);
  std::partial_sort(places.begin(),
                    places.begin() + static_cast<std::ptrdiff_t>(kept),
                    places.end(),
                    [](const ScoredPlace& a, const ScoredPlace& b) {
                      return a.score != b.score ? a.score > b.score : a.id < b.id;
                    });
  places.resize(kept);
  return places;
}

std::size_t ScoredPlaces::memory_bytes() const {
  constexpr std::size_t kPerPlace = sizeof(int) + 48;  // a number, and a node of the map
  std::size_t bytes = entries_.capacity() * sizeof(Entry) + ids_.size() * kPerPlace +
                      postings_.capacity() * sizeof(std::vector<Posting>);
  for (const auto& postings : postings_) {
    bytes += postings.capacity() * sizeof(Posting);
  }
  return bytes;
}

}  // namespace deja_view
