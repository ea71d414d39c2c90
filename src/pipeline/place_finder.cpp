#include "place_finder.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace deja_view {
namespace {

constexpr int kRealImage = 0;

int TagOf(int view) {
  return view + 1;
}

}  // namespace

PlaceFinder::PlaceFinder(const PlaceDatabaseOptions& place,
                         const ScoringOptions& scoring,
                         const CandidateOptions& candidates,
                         std::shared_ptr<const Vocabulary> vocabulary)
    : place_options_(place),
      scoring_(scoring),
      options_(candidates),
      vocabulary_(std::move(vocabulary)),
      places_(place_options_, vocabulary_) {
  if (scoring_.is_on) {
    scored_.emplace(scoring_, vocabulary_);
  }
  empty_bytes_ = memory_bytes();
}

std::uint64_t PlaceFinder::words_identity() const {
  return Hash64(scoring_.is_on ? fmt::format("{} {} {} {:a}",
                                             vocabulary_->identity(),
                                             static_cast<int>(scoring_.weights),
                                             scoring_.synonym_radius,
                                             scoring_.synonym_sigma)
                               : fmt::format("{}", vocabulary_->identity()));
}

ImageWords PlaceFinder::Words(const std::vector<Descriptor>& descriptors) const {
  return Weighted(Bag(descriptors));
}

PackedBow PlaceFinder::PackedWords(const std::vector<Descriptor>& descriptors) const {
  const ImageWords words = Words(descriptors);
  return Pack(words.bow, words.weighted);
}

ImageWords PlaceFinder::Weighted(BowVector bow) const {
  ImageWords words;
  words.bow = std::move(bow);
  if (scored_) {
    words.weighted = scored_->Weigh(words.bow);
  }
  return words;
}

void PlaceFinder::Index(int keyframe, const ImageWords& words, int tag) {
  if (scored_) {
    scored_->Add(keyframe, words.bow, words.weighted, tag);
  } else {
    places_.Add(keyframe, words.bow, tag);
  }
  (tag == kRealImage ? place_words_ : view_words_) += words.bow.entries.size();
}

void PlaceFinder::Add(int keyframe, int sequence, std::int64_t stamp_ns, const ImageWords& words) {
  DEJA_VIEW_CHECK(entries_.empty() || entries_.back().keyframe < keyframe);
  Index(keyframe, words, kRealImage);
  entries_.push_back({keyframe, sequence, stamp_ns});
}

void PlaceFinder::AddAll(const std::vector<NewPlace>& places) {
  if (!scored_) {
    for (const NewPlace& place : places) {
      Add(place.keyframe, place.sequence, place.stamp_ns, {CountsOf(place.words), {}});
    }
    return;
  }
  std::vector<WeighedImage> images;
  for (const NewPlace& place : places) {
    DEJA_VIEW_CHECK(entries_.empty() || entries_.back().keyframe < place.keyframe);
    images.push_back({place.keyframe, &place.words});
    entries_.push_back({place.keyframe, place.sequence, place.stamp_ns});
    place_words_ += place.words.words.size();
  }
  scored_->AddAll(images, kRealImage);
}

void PlaceFinder::AddView(int keyframe, int view, const BowVector& bow) {
  Index(keyframe, Weighted(bow), TagOf(view));
}

void PlaceFinder::RemoveView(int keyframe, int view) {
  if (scored_) {
    scored_->Remove(keyframe, TagOf(view));
  } else {
    places_.Remove(keyframe, TagOf(view));
  }
}

void PlaceFinder::Clear() {
  places_ = PlaceDatabase(place_options_, vocabulary_);
  if (scored_) {
    scored_->Clear();
  }
  entries_.clear();
  predecessors_.clear();
  place_words_ = view_words_ = 0;
}

int PlaceFinder::NewestOldEnough(const PlaceQuestion& question) const {
  const auto min_age_ns = static_cast<std::int64_t>(options_.min_age_s * 1e9);
  const auto it = std::find_if(entries_.rbegin(), entries_.rend(), [&](const Entry& entry) {
    return entry.sequence != question.sequence || question.stamp_ns - entry.stamp_ns >= min_age_ns;
  });
  return it == entries_.rend() ? -1 : it->keyframe;
}

RetrievedPlace PlaceFinder::Retrieved(int keyframe, double score) const {
  const auto it = std::lower_bound(
      entries_.begin(), entries_.end(), keyframe, [](const Entry& entry, int wanted) {
        return entry.keyframe < wanted;
      });
  DEJA_VIEW_CHECK(it != entries_.end() && it->keyframe == keyframe);
  return {keyframe, score, it->sequence, it->stamp_ns};
}

// The most similar keyframes, each as similar as the most similar of its images.
std::vector<RetrievedPlace> PlaceFinder::RetrieveFast(const ImageWords& words,
                                                      int newest,
                                                      std::optional<BestPlace>* best) const {
  PlaceQuery query;
  query.max_results = options_.retrieved;
  query.max_id = newest;
  query.min_score = options_.min_score;
  query.best_per_id = true;
  std::vector<RetrievedPlace> retrieved;
  for (const PlaceMatch& match : places_.Query(words.bow, query)) {
    retrieved.push_back(Retrieved(match.id, match.score));
  }
  if (!retrieved.empty()) {
    *best = BestPlace{retrieved.front().keyframe, retrieved.front().score};
  }
  return retrieved;
}

std::vector<RetrievedPlace> PlaceFinder::RetrieveScored(const ImageWords& words,
                                                        int newest,
                                                        std::optional<BestPlace>* best) const {
  const auto judged = static_cast<std::size_t>(scoring_.neighbours);
  const auto offered = static_cast<std::size_t>(options_.retrieved);
  std::vector<RetrievedPlace> retrieved;
  for (const ScoredPlace& place :
       scored_->Query(words.weighted, newest, std::max(judged, offered))) {
    retrieved.push_back(Retrieved(place.id, place.score));
  }
  const std::vector<RetrievedPlace> neighbours(
      retrieved.begin(),
      retrieved.begin() + static_cast<std::ptrdiff_t>(std::min(judged, retrieved.size())));
  const double own = OwnScore(words.weighted);
  std::vector<RetrievedPlace> passed;
  for (const auto& island : GroupIntoIslands(neighbours, options_.island_gap_s)) {
    std::vector<double> scores;
    scores.reserve(island.size());
    for (const RetrievedPlace& place : island) {
      scores.push_back(place.score);
    }
    const double score = ThresholdScore(scores, scoring_.threshold, own);
    if (!*best || score > (*best)->score) {
      *best = BestPlace{island.front().keyframe, score};
    }
    if (score >= scoring_.r) {
      passed.insert(passed.end(), island.begin(), island.end());
    }
  }
  return scoring_.r > 0 ? passed : retrieved;
}

double PlaceFinder::OwnScore(const WeightedBow& words) const {
  double best = 0;
  for (const WeightedBow& predecessor : predecessors_) {
    best = std::max(best, CosineSimilarity(words, predecessor));
  }
  return best;
}

void PlaceFinder::Pass(ImageWords words) {
  constexpr std::size_t kPredecessors = 3;
  if (scored_) {
    predecessors_.push_back(std::move(words.weighted));
    if (predecessors_.size() > kPredecessors) {
      predecessors_.pop_front();
    }
  }
}

FoundPlaces PlaceFinder::Find(const PlaceQuestion& question, const ImageWords& words) const {
  FoundPlaces found;
  const int newest = NewestOldEnough(question);
  if (newest < 0) {
    return found;
  }
  std::vector<RetrievedPlace> retrieved = scored_ ? RetrieveScored(words, newest, &found.best)
                                                  : RetrieveFast(words, newest, &found.best);
  std::vector<NearbyPlace> old_enough;
  std::copy_if(question.around.begin(),
               question.around.end(),
               std::back_inserter(old_enough),
               [&](const NearbyPlace& place) { return place.keyframe <= newest; });
  found.candidates = MergeCandidates(CandidatesFromIslands(std::move(retrieved), options_),
                                     CandidatesNearby(old_enough, question.here, options_),
                                     question.is_localised,
                                     options_);
  return found;
}

std::size_t PlaceFinder::memory_bytes() const {
  return places_.memory_bytes() + (scored_ ? scored_->memory_bytes() : 0);
}

std::size_t PlaceFinder::view_memory_bytes() const {
  const double words = static_cast<double>(place_words_ + view_words_);
  const double share = words > 0 ? static_cast<double>(view_words_) / words : 0.0;
  const std::size_t grown = memory_bytes() - std::min(memory_bytes(), empty_bytes_);
  return static_cast<std::size_t>(share * static_cast<double>(grown));
}

}  // namespace deja_view
