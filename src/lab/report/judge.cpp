#include "deja_view/lab/report/run.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace deja_view::report {
namespace {

constexpr std::int64_t kMaxTruthGapNs = 100'000'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<Eigen::Vector3d> Positions(const Trajectory& trajectory) {
  std::vector<Eigen::Vector3d> positions;
  for (const Rigid3& pose : trajectory.poses) {
    positions.push_back(pose.t);
  }
  return positions;
}

/// Statistics over the keyframes with truth; moves all positions into the truth's frame.
std::optional<ApeStatistics> Align(const std::vector<std::optional<Rigid3>>& truth,
                                   std::vector<Eigen::Vector3d>* positions,
                                   std::vector<double>* errors) {
  std::vector<Eigen::Vector3d> true_positions;
  std::vector<Eigen::Vector3d> estimates;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i]) {
      true_positions.push_back(truth[i]->t);
      estimates.push_back((*positions)[i]);
    }
  }
  errors->assign(truth.size(), kNaN);
  if (true_positions.size() < 3) {
    return std::nullopt;
  }
  ApeStatistics ape = ComputeApe(true_positions, estimates);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    Eigen::Vector3d& p = (*positions)[i];
    p = ape.T_truth_estimate * p;
    if (truth[i]) {
      (*errors)[i] = (truth[i]->t - p).norm();
    }
  }
  return ape;
}

void CutTruthPath(const Trajectory& truth, JudgedRun* judged) {
  const auto& stamps = judged->run.vio.stamps_ns;
  for (std::size_t i = 0; i < truth.size() && !stamps.empty(); ++i) {
    if (truth.stamps_ns[i] >= stamps.front() && truth.stamps_ns[i] <= stamps.back()) {
      judged->truth_path.push_back(truth.poses[i].t);
    }
  }
}

/// Keyframes of the run, then those of a loaded map that loops lead to.
class KeyframeList {
 public:
  KeyframeList(const Trajectory& vio, const Trajectory& truth) : truth_(truth) {
    for (const std::int64_t stamp : vio.stamps_ns) {
      Add(stamp, false);
    }
  }
  int IndexOf(std::int64_t stamp_ns) {
    const auto found = indices_.find(stamp_ns);
    return found != indices_.end() ? found->second : Add(stamp_ns, true);
  }
  const std::vector<TrueKeyframe>& keyframes() const { return keyframes_; }

 private:
  int Add(std::int64_t stamp_ns, bool is_old_only) {
    const auto index = static_cast<int>(keyframes_.size());
    indices_.emplace(stamp_ns, index);
    keyframes_.push_back({stamp_ns, truth_.At(stamp_ns, kMaxTruthGapNs), is_old_only});
    return index;
  }

  const Trajectory& truth_;
  std::vector<TrueKeyframe> keyframes_;
  std::unordered_map<std::int64_t, int> indices_;
};

void JudgeLoops(const std::optional<Rigid3>& T_B_C,
                const LoopCriteria& criteria,
                KeyframeList* list,
                JudgedRun* judged) {
  const auto own = static_cast<int>(judged->run.vio.size());
  std::vector<EvaluatedLoop> all;
  std::vector<EvaluatedLoop> accepted;
  for (const LoopRecord& loop : judged->run.loops) {
    const int current = list->IndexOf(loop.stamp_current_ns);
    const int old = list->IndexOf(loop.stamp_old_ns);
    all.push_back({old, current, loop.T_Bold_Bcurrent});
    if (loop.accepted) {
      accepted.push_back(all.back());
    }
    judged->ends.emplace_back(current < own ? current : -1, old < own ? old : -1);
    judged->has_other_keyframes |= current >= own || old >= own;
  }
  const std::vector<TrueKeyframe>& keyframes = list->keyframes();
  const LoopScore of_all = ScoreLoops(keyframes, all, T_B_C.value_or(Rigid3()), criteria);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_known = keyframes[static_cast<std::size_t>(all[i].current)].T_truth_B &&
                          keyframes[static_cast<std::size_t>(all[i].old)].T_truth_B;
    const Verdict verdict = of_all.is_correct[i] ? Verdict::kCorrect : Verdict::kWrong;
    judged->verdicts.push_back(is_known ? verdict : Verdict::kUnknown);
  }
  judged->score = ScoreLoops(keyframes, accepted, T_B_C.value_or(Rigid3()), criteria);
}

void FindRevisits(const std::vector<TrueKeyframe>& keyframes,
                  const Rigid3& T_B_C,
                  const LoopCriteria& criteria,
                  JudgedRun* judged) {
  for (std::size_t current = 0; current < judged->run.vio.size(); ++current) {
    for (std::size_t old = 0; old < current; ++old) {
      if (IsRevisit(keyframes[current], keyframes[old], T_B_C, criteria)) {
        judged->revisits.emplace_back(static_cast<int>(current), static_cast<int>(old));
      }
    }
  }
}

}  // namespace

int JudgedRun::AcceptedLoops() const {
  return static_cast<int>(std::count_if(
      run.loops.begin(), run.loops.end(), [](const LoopRecord& loop) { return loop.accepted; }));
}

JudgedRun Judge(RunData run,
                const Trajectory& truth,
                const std::optional<Rigid3>& T_B_C,
                const LoopCriteria& criteria) {
  JudgedRun judged;
  judged.run = std::move(run);
  judged.has_camera = T_B_C.has_value();
  for (const std::int64_t stamp : judged.run.vio.stamps_ns) {
    judged.times_s.push_back(1e-9 * static_cast<double>(stamp - judged.run.vio.stamps_ns.front()));
  }
  CutTruthPath(truth, &judged);
  KeyframeList list(judged.run.vio, truth);
  std::vector<std::optional<Rigid3>> true_poses;
  for (const TrueKeyframe& keyframe : list.keyframes()) {
    true_poses.push_back(keyframe.T_truth_B);
  }
  judged.vio = Positions(judged.run.vio);
  judged.corrected = Positions(judged.run.corrected);
  judged.vio_ape = Align(true_poses, &judged.vio, &judged.vio_errors);
  judged.corrected_ape = Align(true_poses, &judged.corrected, &judged.corrected_errors);
  JudgeLoops(T_B_C, criteria, &list, &judged);
  if (T_B_C) {
    FindRevisits(list.keyframes(), *T_B_C, criteria, &judged);
  }
  if (truth.empty()) {
    judged.score.reset();
  }
  return judged;
}

}  // namespace deja_view::report
