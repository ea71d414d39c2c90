// Which keyframes may show the same place: by their words, and near the corrected pose.
#include <algorithm>
#include <iterator>
#include <utility>

#include "loop_closer_impl.hpp"
#include "stopwatch.hpp"

namespace deja_view {
namespace {

constexpr double kLocalisedSeconds = 5.0;  // how long the corrected pose is the better guess

}  // namespace

int LoopCloser::Impl::NewestOldEnough() const {
  const StoredKeyframe& current = keyframes.back();
  const auto min_age_ns = static_cast<std::int64_t>(options.candidates.min_age_s * 1e9);
  for (int i = static_cast<int>(keyframes.size()) - 2; i >= 0; --i) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(i)];
    if (k.sequence != current.sequence || current.stamp_ns - k.stamp_ns >= min_age_ns) {
      return i;
    }
  }
  return -1;
}

NearbyPlace LoopCloser::Impl::PlaceOf(int keyframe) const {
  const auto k = static_cast<std::size_t>(keyframe);
  const Rigid3 T_M_C = graph.nodes()[k].T_M_B() * keyframes[k].features.T_B_C;
  return {keyframe, T_M_C.t, T_M_C.q * Eigen::Vector3d::UnitZ()};
}

bool LoopCloser::Impl::IsLocalised() const {
  if (last_localised_ < 0) {
    return false;
  }
  const StoredKeyframe& last = keyframes[static_cast<std::size_t>(last_localised_)];
  const StoredKeyframe& current = keyframes.back();
  return last.sequence == current.sequence &&
         static_cast<double>(current.stamp_ns - last.stamp_ns) < kLocalisedSeconds * 1e9;
}

// A virtual camera is a place from which its keyframe knows the hall, too.
void LoopCloser::Impl::AddViewPlaces(int keyframe, std::vector<NearbyPlace>* around) const {
  const auto k = static_cast<std::size_t>(keyframe);
  for (const StoredView& view : keyframes[k].views) {
    const Rigid3 T_M_V = graph.nodes()[k].T_M_B() * keyframes[k].features.T_B_C * view.T_C_V;
    around->push_back({keyframe, T_M_V.t, T_M_V.q * Eigen::Vector3d::UnitZ()});
  }
}

// The most similar keyframes, each as similar as the most similar of its images.
std::vector<RetrievedPlace> LoopCloser::Impl::RetrieveFast(int newest) const {
  PlaceQuery query;
  query.max_results = options.candidates.retrieved;
  query.max_id = newest;
  query.min_score = options.candidates.min_score;
  query.best_per_id = true;
  std::vector<RetrievedPlace> retrieved;
  for (const PlaceMatch& match : places.Query(keyframes.back().bow, query)) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(match.id)];
    retrieved.push_back({match.id, match.score, k.sequence, k.stamp_ns});
  }
  return retrieved;
}

std::vector<RetrievedPlace> LoopCloser::Impl::Retrieve(int newest, KeyframeReport* report) const {
  if (scored_places_) {
    return RetrieveScored(newest, report);
  }
  std::vector<RetrievedPlace> retrieved = RetrieveFast(newest);
  if (!retrieved.empty()) {
    report->best_place = BestPlace{retrieved.front().keyframe, retrieved.front().score};
  }
  return retrieved;
}

std::vector<RetrievedPlace> LoopCloser::Impl::RetrieveScored(int newest,
                                                             KeyframeReport* report) const {
  const ScoringOptions& scoring = options.scoring;
  std::vector<RetrievedPlace> retrieved;
  for (const ScoredPlace& place : scored_places_->Query(
           weighted_words_, newest, static_cast<std::size_t>(scoring.neighbours))) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(place.id)];
    retrieved.push_back({place.id, place.score, k.sequence, k.stamp_ns});
  }
  const double own = OwnScore(weighted_words_);
  std::vector<RetrievedPlace> passed;
  for (const auto& island : GroupIntoIslands(retrieved, options.candidates.island_gap_s)) {
    std::vector<double> scores;
    for (const RetrievedPlace& place : island) {
      scores.push_back(place.score);
    }
    const double score = ThresholdScore(scores, scoring.threshold, own);
    if (!report->best_place || score > report->best_place->score) {
      report->best_place = BestPlace{island.front().keyframe, score};
    }
    if (score >= scoring.r) {
      passed.insert(passed.end(), island.begin(), island.end());
    }
  }
  return passed;
}

double LoopCloser::Impl::OwnScore(const WeightedBow& words) const {
  double best = 0;
  for (const WeightedBow& predecessor : predecessors_) {
    best = std::max(best, CosineSimilarity(words, predecessor));
  }
  return best;
}

void LoopCloser::Impl::RememberWords() {
  constexpr std::size_t kPredecessors = 3;
  if (scored_places_) {
    predecessors_.push_back(std::move(weighted_words_));
    if (predecessors_.size() > kPredecessors) {
      predecessors_.pop_front();
    }
  }
}

std::vector<Candidate> LoopCloser::Impl::FindCandidates(KeyframeReport* report) const {
  Stopwatch watch;
  const int newest = NewestOldEnough();
  if (newest < 0) {
    return {};
  }
  std::vector<RetrievedPlace> retrieved = Retrieve(newest, report);
  std::vector<NearbyPlace> around;
  for (int i = 0; i <= newest && options.candidates.nearby > 0; ++i) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(i)];
    if (k.is_place && graph.AreJoined(k.sequence, keyframes.back().sequence)) {
      around.push_back(PlaceOf(i));
      AddViewPlaces(i, &around);
    }
  }
  const auto nearby =
      CandidatesNearby(around, PlaceOf(static_cast<int>(keyframes.size()) - 1), options.candidates);
  auto candidates = MergeCandidates(CandidatesFromIslands(std::move(retrieved), options.candidates),
                                    nearby,
                                    IsLocalised(),
                                    options.candidates);
  report->times.query = watch.LapMs();
  return candidates;
}
}  // namespace deja_view
