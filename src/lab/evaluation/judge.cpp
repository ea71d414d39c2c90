#include "deja_view/lab/evaluation/judge.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace deja_view {
namespace {

constexpr std::int64_t kMaxGapNs = 100'000'000;

std::size_t At(int index) {
  return static_cast<std::size_t>(index);
}

void FindTruth(const Flight& flight, const FlightTruth& truth, JudgedFlight* judged) {
  for (const FlownKeyframe& flown : flight.keyframes) {
    const Trajectory& poses = flown.is_of_map ? truth.map : truth.own;
    judged->keyframes.push_back(
        {flown.stamp_ns, poses.At(flown.stamp_ns, kMaxGapNs), flown.is_of_map});
  }
}

void JudgeLoops(const Flight& flight,
                const Rigid3& T_B_C,
                const LoopCriteria& criteria,
                JudgedFlight* judged) {
  std::vector<EvaluatedLoop> accepted;
  for (const FlownLoop& loop : flight.loops) {
    const EvaluatedLoop evaluated{loop.old, loop.current, loop.T_Bold_Bcurrent};
    const std::optional<LoopError> error = ErrorOf(judged->keyframes, evaluated);
    const bool is_correct = error && IsWithin(*error, criteria);
    judged->verdicts.push_back(!error       ? Verdict::kUnknown
                               : is_correct ? Verdict::kCorrect
                                            : Verdict::kWrong);
    if (loop.is_accepted) {
      accepted.push_back(evaluated);
      judged->virtual_loops += loop.is_virtual ? 1 : 0;
      judged->virtual_correct += loop.is_virtual && is_correct ? 1 : 0;
    }
  }
  judged->score = ScoreLoops(judged->keyframes, accepted, T_B_C, criteria);
}

/// True for a keyframe of the flight that sees one of the places that `is_candidate(old)` again.
template <typename IsCandidate>
bool SeesPlace(const Flight& flight,
               const std::vector<TrueKeyframe>& keyframes,
               std::size_t current,
               const Rigid3& T_B_C,
               const JudgeOptions& options,
               const IsCandidate& is_candidate) {
  for (std::size_t old = 0; old < keyframes.size(); ++old) {
    const bool is_map = flight.keyframes[old].is_of_map;
    if ((is_map || old < current) && is_candidate(flight.keyframes[old]) &&
        IsRevisit(keyframes[current],
                  keyframes[old],
                  T_B_C,
                  is_map ? options.map_criteria : options.criteria)) {
      return true;
    }
  }
  return false;
}

/// Of the keyframes that see a place of the loaded map, how many were tied to the map.
void JudgeMap(const Flight& flight,
              const Rigid3& T_B_C,
              const JudgeOptions& options,
              JudgedFlight* judged) {
  const std::vector<TrueKeyframe>& keyframes = judged->keyframes;
  std::vector<bool> is_tied(keyframes.size(), false);
  for (std::size_t i = 0; i < flight.loops.size(); ++i) {
    const FlownLoop& loop = flight.loops[i];
    if (loop.is_accepted && judged->verdicts[i] == Verdict::kCorrect &&
        flight.keyframes[At(loop.old)].is_of_map) {
      is_tied[At(loop.current)] = true;
    }
  }
  std::vector<TrueKeyframe> places;
  std::vector<TrueKeyframe> own;
  std::vector<bool> is_found;
  bool has_map = false;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    if (flight.keyframes[i].is_of_map) {
      has_map = true;
      if (flight.keyframes[i].is_place) {
        places.push_back(keyframes[i]);
      }
      continue;
    }
    own.push_back(keyframes[i]);
    is_found.push_back(is_tied[i]);
    const bool is_revisit =
        SeesPlace(flight, keyframes, i, T_B_C, options, [](const FlownKeyframe& old) {
          return old.is_of_map && old.is_place;
        });
    judged->map_revisits += is_revisit ? 1 : 0;
    judged->map_revisits_found += is_revisit && is_tied[i] ? 1 : 0;
  }
  if (has_map) {
    judged->relocalisation = MakeRelocalisationCurve(places, own, is_found, T_B_C);
  }
}

/// Per keyframe: one of the flight's that sees an older place again.
std::vector<bool> FindRevisits(const Flight& flight,
                               const std::vector<TrueKeyframe>& keyframes,
                               const Rigid3& T_B_C,
                               const JudgeOptions& options) {
  const bool is_flight_searched =
      std::any_of(flight.keyframes.begin(), flight.keyframes.end(), [](const FlownKeyframe& own) {
        return !own.is_of_map && own.is_place;
      });
  std::vector<bool> is_revisit;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    is_revisit.push_back(
        !flight.keyframes[i].is_of_map &&
        SeesPlace(flight, keyframes, i, T_B_C, options, [&](const FlownKeyframe& old) {
          return old.is_of_map ? old.is_place : is_flight_searched;
        }));
  }
  return is_revisit;
}

/// How well scores alone tell revisits from other keyframes.
void SweepDetections(const Flight& flight,
                     const Rigid3& T_B_C,
                     const JudgeOptions& options,
                     const std::vector<bool>& is_revisit,
                     JudgedFlight* judged) {
  std::vector<ScoredDecision> known;
  for (const FlownDetection& detection : flight.detections) {
    const TrueKeyframe& current = judged->keyframes[At(detection.current)];
    const TrueKeyframe& old = judged->keyframes[At(detection.old)];
    const LoopCriteria& criteria =
        flight.keyframes[At(detection.old)].is_of_map ? options.map_criteria : options.criteria;
    judged->decisions.emplace_back();
    if (current.T_truth_B && old.T_truth_B) {
      known.push_back({detection.score,
                       IsRevisit(current, old, T_B_C, criteria),
                       is_revisit[At(detection.current)]});
      judged->decisions.back() = known.back();
    }
  }
  const auto revisits = static_cast<int>(std::count(is_revisit.begin(), is_revisit.end(), true));
  judged->detections = SweepThreshold(std::move(known), revisits);
}

/// The largest recall of loops from some score on, all of them correct. A keyframe is recalled
/// once, by the correct loop of its largest score.
double RecallAtPrecision1(const Flight& flight,
                          const std::vector<Verdict>& verdicts,
                          const std::vector<bool>& is_revisit) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < flight.loops.size(); ++i) {
    if (flight.loops[i].is_accepted) {
      order.push_back(i);
    }
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return flight.loops[i].score > flight.loops[j].score;
  });
  std::vector<bool> is_left = is_revisit;
  std::vector<ScoredDecision> decisions;
  for (const std::size_t i : order) {
    const bool is_correct = verdicts[i] == Verdict::kCorrect;
    const std::size_t current = At(flight.loops[i].current);
    decisions.push_back({flight.loops[i].score, is_correct, is_left[current]});
    is_left[current] = is_left[current] && !is_correct;
  }
  const auto revisits = static_cast<int>(std::count(is_revisit.begin(), is_revisit.end(), true));
  return PickThreshold(SweepThreshold(std::move(decisions), revisits), 1.0).recall;
}

/// Positions of keyframes where the truth covers them.
struct Paired {
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> corrected;
  std::vector<Eigen::Vector3d> vio;
};

void MeasureErrors(const Flight& flight, JudgedFlight* judged) {
  constexpr std::size_t kMinPoses = 3;
  Paired own;
  Paired map;
  for (std::size_t i = 0; i < flight.keyframes.size(); ++i) {
    const FlownKeyframe& flown = flight.keyframes[i];
    const std::optional<Rigid3>& T_truth_B = judged->keyframes[i].T_truth_B;
    if (T_truth_B && flown.has_poses) {
      Paired& paired = flown.is_of_map ? map : own;
      paired.truth.push_back(T_truth_B->t);
      paired.corrected.push_back(flown.T_M_B.t);
      paired.vio.push_back(flown.T_W_B.t);
    }
  }
  if (own.truth.size() >= kMinPoses) {
    judged->ape = ComputeApe(own.truth, own.corrected);
    judged->vio_ape = ComputeApe(own.truth, own.vio);
  }
  if (map.truth.size() >= kMinPoses && !own.truth.empty()) {
    const Rigid3 T_truth_M = ComputeApe(map.truth, map.corrected).T_truth_estimate;
    for (Eigen::Vector3d& p : own.corrected) {
      p = T_truth_M * p;
    }
    judged->map_frame_ape = ComputeApeUnaligned(own.truth, own.corrected);
  }
}

}  // namespace

JudgedFlight JudgeFlight(const Flight& flight,
                         const FlightTruth& truth,
                         const Rigid3& T_B_C,
                         const JudgeOptions& options) {
  JudgedFlight judged;
  FindTruth(flight, truth, &judged);
  JudgeLoops(flight, T_B_C, options.criteria, &judged);
  JudgeMap(flight, T_B_C, options, &judged);
  const std::vector<bool> is_revisit = FindRevisits(flight, judged.keyframes, T_B_C, options);
  SweepDetections(flight, T_B_C, options, is_revisit, &judged);
  judged.recall_at_precision_1 = RecallAtPrecision1(flight, judged.verdicts, is_revisit);
  MeasureErrors(flight, &judged);
  return judged;
}

}  // namespace deja_view
