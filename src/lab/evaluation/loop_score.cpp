#include "deja_view/lab/evaluation/loop_score.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view {

std::optional<LoopError> ErrorOf(const std::vector<TrueKeyframe>& keyframes,
                                 const EvaluatedLoop& loop) {
  const TrueKeyframe& old = keyframes.at(static_cast<std::size_t>(loop.old));
  const TrueKeyframe& current = keyframes.at(static_cast<std::size_t>(loop.current));
  if (!old.T_truth_B || !current.T_truth_B) {
    return std::nullopt;
  }
  const Rigid3 error =
      loop.T_Bold_Bcurrent.Inverse() * (old.T_truth_B->Inverse() * *current.T_truth_B);
  return LoopError{error.t.norm(), RotationAngle(error.q) / kDegree};
}

bool IsWithin(const LoopError& error, const LoopCriteria& criteria) {
  return error.distance_m < criteria.max_error_m && error.angle_deg < criteria.max_error_deg;
}

bool IsRevisit(const TrueKeyframe& current,
               const TrueKeyframe& old,
               const Rigid3& T_B_C,
               const LoopCriteria& criteria) {
  const bool is_older = old.is_old_only || static_cast<double>(current.stamp_ns - old.stamp_ns) >=
                                               criteria.revisit_age_s * 1e9;
  if (!is_older || !current.T_truth_B || !old.T_truth_B ||
      (current.T_truth_B->t - old.T_truth_B->t).norm() > criteria.revisit_distance_m) {
    return false;
  }
  const Eigen::Vector3d axis = T_B_C.q * Eigen::Vector3d::UnitZ();
  return (current.T_truth_B->q * axis).dot(old.T_truth_B->q * axis) >
         std::cos(criteria.revisit_angle_deg * kDegree);
}

namespace {

/// Judges each loop; returns, per keyframe, whether a correct one is its.
std::vector<bool> CountLoops(const std::vector<TrueKeyframe>& keyframes,
                             const std::vector<EvaluatedLoop>& loops,
                             const LoopCriteria& criteria,
                             LoopScore* score) {
  std::vector<bool> is_found(keyframes.size(), false);
  for (const EvaluatedLoop& loop : loops) {
    const std::optional<LoopError> error = ErrorOf(keyframes, loop);
    const bool is_correct = error && IsWithin(*error, criteria);
    ++score->accepted;
    if (error) {
      ++score->judged;
      score->worst.distance_m = std::max(score->worst.distance_m, error->distance_m);
      score->worst.angle_deg = std::max(score->worst.angle_deg, error->angle_deg);
    }
    score->correct += is_correct ? 1 : 0;
    score->is_correct.push_back(is_correct);
    if (is_correct) {
      is_found[static_cast<std::size_t>(loop.current)] = true;
    }
  }
  return is_found;
}

}  // namespace

LoopScore ScoreLoops(const std::vector<TrueKeyframe>& keyframes,
                     const std::vector<EvaluatedLoop>& loops,
                     const Rigid3& T_B_C,
                     const LoopCriteria& criteria) {
  LoopScore score;
  const std::vector<bool> is_found = CountLoops(keyframes, loops, criteria, &score);
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const TrueKeyframe& current = keyframes[i];
    if (current.is_old_only || !current.T_truth_B) {
      continue;
    }
    bool is_revisit = false;
    for (std::size_t j = 0; j < keyframes.size() && !is_revisit; ++j) {
      is_revisit = j != i && IsRevisit(current, keyframes[j], T_B_C, criteria);
    }
    score.revisits += is_revisit ? 1 : 0;
    score.revisits_found += is_revisit && is_found[i] ? 1 : 0;
  }
  return score;
}

}  // namespace deja_view
