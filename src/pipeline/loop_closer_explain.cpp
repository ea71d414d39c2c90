// Why two keyframes were joined or not.
#include <algorithm>
#include <cstdlib>

#include "loop_closer_impl.hpp"

namespace deja_view {

void LoopCloserImpl::Ask(std::int64_t stamp_current_ns,
                         std::int64_t stamp_old_ns,
                         std::int64_t within_ns) {
  question_ = Question{stamp_current_ns, stamp_old_ns, within_ns, -1, {}};
  for (const int place : keyframes_.places()) {
    if (std::abs(keyframes_[place].stamp_ns - stamp_old_ns) <= within_ns) {
      question_->old = place;
    }
  }
}

bool LoopCloserImpl::IsMeant(std::int64_t stamp_ns) const {
  return std::abs(keyframes_[keyframes_.newest()].stamp_ns - stamp_ns) <= question_->within_ns;
}

PairExplanation::Attempt LoopCloserImpl::Attempt(int old,
                                                 const KeyframeFeatures& old_features,
                                                 bool with_views,
                                                 const NewKeyframe& current) const {
  PairExplanation::Attempt attempt;
  attempt.verification = VerifyPair(old, old_features, with_views, current);
  if (attempt.verification.inliers > 0) {
    attempt.readings = verifier_.Readings(attempt.verification, with_views);
    attempt.pairs = PairsOf(attempt.verification);
  }
  return attempt;
}

void LoopCloserImpl::Explain(const std::vector<Candidate>& candidates,
                             const NewKeyframe& current,
                             KeyframeReport* report) {
  const int newest = keyframes_.newest();
  if (!question_ || question_->old < 0 || !IsMeant(question_->stamp_current_ns)) {
    return;
  }
  const int old = question_->old;
  PairExplanation& pair = report->explanation.emplace();
  pair.current = newest;
  pair.old = old;
  pair.stamp_current_ns = keyframes_[newest].stamp_ns;
  pair.stamp_old_ns = keyframes_[old].stamp_ns;
  pair.is_place = keyframes_[old].is_place;
  const KeyframeFeatures& old_features =
      pair.is_place ? keyframes_.features(old) : question_->old_features;
  pair.points_current = static_cast<int>(current.features.points_B.size());
  pair.points_old = static_cast<int>(old_features.points_B.size());
  pair.candidates = static_cast<int>(candidates.size());
  const auto tried = std::find_if(candidates.begin(), candidates.end(), [&](const auto& candidate) {
    return candidate.keyframe == old;
  });
  if (tried != candidates.end()) {
    pair.rank = static_cast<int>(tried - candidates.begin());
    pair.score = tried->score;
  }
  if (keyframes_.AreJoined(old, newest)) {
    pair.T_Bold_Bcurrent_predicted = keyframes_.T_a_b(old, newest);
    pair.predicted_overlap =
        OverlapShare(current.features, old_features, *pair.T_Bold_Bcurrent_predicted, *camera_);
  }
  pair.first_matches = verifier_.FirstMatches(current.features, old_features);
  pair.real = Attempt(old, old_features, false, current);
  pair.reason = pair.real.verification.reason;
  if (!shelf_.Of(old).empty() && pair.reason != RejectReason::kNone) {
    pair.with_views = Attempt(old, old_features, true, current);
    pair.reason = pair.with_views->verification.reason;
  }
  for (const LoopReport& loop : report->loops) {
    if (loop.current == newest && loop.old == old) {
      pair.reason = loop.reason;
    }
  }
  question_.reset();
}

}  // namespace deja_view
