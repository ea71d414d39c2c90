#include "deja_view/place/scored_places.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <map>
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
  Entry entry{id, tag, Weigh(bow)};
  for (const WeightedWord& w : entry.words) {
    postings_.at(w.word).push_back({entries_.size(), w.weight});
  }
  entries_.push_back(std::move(entry));
}

void ScoredPlaces::Remove(int id, int tag) {
  for (Entry& entry : entries_) {
    if (entry.id == id && entry.tag == tag) {
      entry.id = -1;
    }
  }
}

void ScoredPlaces::Clear() {
  entries_.clear();
  postings_.assign(postings_.size(), {});
}

std::vector<ScoredPlace> ScoredPlaces::Query(const WeightedBow& query,
                                             int max_id,
                                             std::size_t count) const {
  std::vector<double> cosines(entries_.size(), 0.0);
  for (const WeightedWord& w : query) {
    for (const Posting& posting : postings_.at(w.word)) {
      cosines[posting.entry] += w.weight * posting.weight;
    }
  }
  std::map<int, std::pair<double, double>> by_id;  // original, best virtual or -1
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (entry.id < 0 || entry.id > max_id) {
      continue;
    }
    const double cosine = std::min(1.0, cosines[i]);
    auto& [original, best_view] = by_id.try_emplace(entry.id, 0.0, -1.0).first->second;
    if (entry.tag == 0) {
      original = cosine;
    } else {
      best_view = std::max(best_view, cosine);
    }
  }
  std::vector<ScoredPlace> places;
  for (const auto& [id, scores] : by_id) {
    const auto& [original, best_view] = scores;
    const double view = best_view < 0 ? original : best_view;
    const double score = CombineScores(original, view, {options_.alpha, options_.beta}).score;
    if (score > 0) {
      places.push_back({id, original, view, score});
    }
  }
  std::stable_sort(places.begin(), places.end(), [](const ScoredPlace& a, const ScoredPlace& b) {
    return a.score > b.score;
  });
  places.resize(std::min(places.size(), count));
  return places;
}

std::size_t ScoredPlaces::memory_bytes() const {
  std::size_t bytes =
      entries_.capacity() * sizeof(Entry) + postings_.capacity() * sizeof(std::vector<Posting>);
  for (const Entry& entry : entries_) {
    bytes += entry.words.capacity() * sizeof(WeightedWord);
  }
  for (const auto& postings : postings_) {
    bytes += postings.capacity() * sizeof(Posting);
  }
  return bytes;
}

}  // namespace deja_view
