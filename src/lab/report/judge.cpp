#include "deja_view/lab/report/run.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

namespace deja_view::report {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Moves positions into the truth's frame and tells their errors, NaN where there is no truth.
void Place(const Trajectory& trajectory,
           const std::vector<TrueKeyframe>& keyframes,
           const std::optional<ApeStatistics>& ape,
           std::vector<Eigen::Vector3d>* positions,
           std::vector<double>* errors) {
  errors->assign(trajectory.size(), kNaN);
  std::size_t measured = 0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Eigen::Vector3d& p = trajectory.poses[i].t;
    positions->push_back(ape ? ape->T_truth_estimate * p : p);
    if (ape && keyframes[i].T_truth_B) {
      (*errors)[i] = ape->errors[measured++];
    }
  }
}

void CutTruthPath(const Trajectory& truth, JudgedRun* judged) {
  const auto& stamps = judged->run.vio.stamps_ns;
  for (std::size_t i = 0; i < truth.size() && !stamps.empty(); ++i) {
    if (truth.stamps_ns[i] >= stamps.front() && truth.stamps_ns[i] <= stamps.back()) {
      judged->truth_path.push_back(truth.poses[i].t);
    }
  }
}

/// Keyframes of the run, then those of a loaded map that loops lead to, of which the run's files
/// tell only the stamps.
class FlightBuilder {
 public:
  explicit FlightBuilder(const RunData& run) {
    for (std::size_t i = 0; i < run.vio.size(); ++i) {
      Add({run.vio.stamps_ns[i], run.corrected.poses[i], run.vio.poses[i]});
    }
    for (const LoopRecord& loop : run.loops) {
      const int current = IndexOf(loop.stamp_current_ns);
      const int old = IndexOf(loop.stamp_old_ns);
      flight_.loops.push_back(
          {old, current, loop.T_Bold_Bcurrent, loop.score, loop.is_virtual, loop.accepted});
    }
  }
  const Flight& flight() const { return flight_; }

 private:
  int IndexOf(std::int64_t stamp_ns) {
    const auto found = indices_.find(stamp_ns);
    if (found != indices_.end()) {
      return found->second;
    }
    FlownKeyframe keyframe;
    keyframe.stamp_ns = stamp_ns;
    keyframe.is_of_map = true;
    keyframe.has_poses = false;
    return Add(keyframe);
  }
  int Add(const FlownKeyframe& keyframe) {
    const auto index = static_cast<int>(flight_.keyframes.size());
    indices_.emplace(keyframe.stamp_ns, index);
    flight_.keyframes.push_back(keyframe);
    return index;
  }

  Flight flight_;
  std::unordered_map<std::int64_t, int> indices_;
};

void FindEnds(const Flight& flight, JudgedRun* judged) {
  const auto own = static_cast<int>(judged->run.vio.size());
  for (const FlownLoop& loop : flight.loops) {
    judged->ends.emplace_back(loop.current < own ? loop.current : -1,
                              loop.old < own ? loop.old : -1);
    judged->has_other_keyframes |= loop.current >= own || loop.old >= own;
  }
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
  const Flight flight = FlightBuilder(judged.run).flight();
  JudgedFlight of_flight =
      JudgeFlight(flight, {truth, truth}, T_B_C.value_or(Rigid3()), {criteria, criteria});
  FindEnds(flight, &judged);
  Place(judged.run.vio, of_flight.keyframes, of_flight.vio_ape, &judged.vio, &judged.vio_errors);
  Place(judged.run.corrected,
        of_flight.keyframes,
        of_flight.ape,
        &judged.corrected,
        &judged.corrected_errors);
  if (T_B_C) {
    FindRevisits(of_flight.keyframes, *T_B_C, criteria, &judged);
  }
  judged.vio_ape = std::move(of_flight.vio_ape);
  judged.corrected_ape = std::move(of_flight.ape);
  judged.verdicts = std::move(of_flight.verdicts);
  if (!truth.empty()) {
    judged.score = std::move(of_flight.score);
  }
  return judged;
}

}  // namespace deja_view::report
