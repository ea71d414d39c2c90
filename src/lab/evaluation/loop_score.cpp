#include "deja_view/lab/evaluation/loop_score.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include <cmath>

namespace deja_view {
std::optional<bool> IsCorrect(const std::vector<TrueKeyframe>& keyframes,
                              const EvaluatedLoop& loop,
                              const LoopCriteria& criteria) {
  const TrueKeyframe& old = keyframes.at(static_cast<std::size_t>(loop.old));
  const TrueKeyframe& current = keyframes.at(static_cast<std::size_t>(loop.current));
  if (!old.T_truth_B || !current.T_truth_B) {
    return std::nullopt;
  }
  const Rigid3 error =
      loop.T_Bold_Bcurrent.Inverse() * (old.T_truth_B->Inverse() * *current.T_truth_B);
  return error.t.norm() < criteria.max_error_m &&
         RotationAngle(error.q) < criteria.max_error_deg * kDegree;
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

LoopScore ScoreLoops(const std::vector<TrueKeyframe>& keyframes,
                     const std::vector<EvaluatedLoop>& loops,
                     const Rigid3& T_B_C,
                     const LoopCriteria& criteria) {
  LoopScore score;
  std::vector<bool> is_found(keyframes.size(), false);
  for (const EvaluatedLoop& loop : loops) {
    const std::optional<bool> judged = IsCorrect(keyframes, loop, criteria);
    const bool is_correct = judged.value_or(false);
    ++score.accepted;
    score.judged += judged ? 1 : 0;
    score.correct += is_correct ? 1 : 0;
    score.is_correct.push_back(is_correct);
    if (is_correct) {
      is_found[static_cast<std::size_t>(loop.current)] = true;
    }
  }
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
