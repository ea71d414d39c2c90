#include "deja_view/io/tum.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "replay/replay.hpp"

namespace deja_view {
namespace {

/// Positions of the session's own keyframes where the truth covers them.
struct Paired {
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> corrected;
  std::vector<Eigen::Vector3d> vio;
};

/// True per keyframe of the session that sees an older place again.
std::vector<bool> FindRevisits(const ReplayRequest& request,
                               const std::vector<TrueKeyframe>& keyframes,
                               const Rigid3& T_B_C,
                               const ReplayResult& result) {
  const LoopCriteria map_criteria = request.revisits.value_or(LoopCriteria{});
  const auto map_end = static_cast<std::size_t>(result.map_keyframes);
  const bool is_session_searched =
      std::any_of(result.keyframes.begin() + static_cast<std::ptrdiff_t>(map_end),
                  result.keyframes.end(),
                  [](const KeyframeInfo& info) { return info.is_place; });
  std::vector<bool> is_revisit(keyframes.size(), false);
  for (std::size_t current = map_end; current < keyframes.size(); ++current) {
    for (std::size_t old = 0; old < current && !is_revisit[current]; ++old) {
      const bool is_map = old < map_end;
      if (is_map ? result.keyframes[old].is_place : is_session_searched) {
        is_revisit[current] = IsRevisit(
            keyframes[current], keyframes[old], T_B_C, is_map ? map_criteria : LoopCriteria{});
      }
    }
  }
  return is_revisit;
}

/// How well scores alone, and loops from some score on, tell revisits from other keyframes.
void SweepScores(const ReplayRequest& request,
                 const std::vector<TrueKeyframe>& keyframes,
                 const Rigid3& T_B_C,
                 ReplayResult* result) {
  const std::vector<bool> is_revisit = FindRevisits(request, keyframes, T_B_C, *result);
  const auto revisits = static_cast<int>(std::count(is_revisit.begin(), is_revisit.end(), true));
  std::vector<ScoredDecision> detections;
  for (ReplayResult::Best& best : result->best_places) {
    const auto current = static_cast<std::size_t>(best.current);
    const auto old = static_cast<std::size_t>(best.place.old);
    const LoopCriteria criteria = best.place.old < result->map_keyframes
                                      ? request.revisits.value_or(LoopCriteria{})
                                      : LoopCriteria{};
    if (keyframes[current].T_truth_B && keyframes[old].T_truth_B) {
      best.decision = {best.place.score,
                       IsRevisit(keyframes[current], keyframes[old], T_B_C, criteria),
                       is_revisit[current]};
      detections.push_back(*best.decision);
    }
  }
  result->detections = SweepThreshold(std::move(detections), revisits);
  std::vector<ScoredDecision> decisions;
  std::vector<const LoopRow*> accepted;
  for (const LoopRow& loop : result->loops) {
    if (loop.accepted()) {
      accepted.push_back(&loop);
    }
  }
  // A keyframe is recalled once, by its first right loop.
  std::vector<bool> is_left = is_revisit;
  std::vector<std::size_t> order(accepted.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return accepted[i]->score > accepted[j]->score;
  });
  for (const std::size_t i : order) {
    const bool is_correct = result->score->is_correct[i];
    const auto current = static_cast<std::size_t>(accepted[i]->current);
    decisions.push_back({accepted[i]->score, is_correct, is_left[current]});
    is_left[current] = is_left[current] && !is_correct;
  }
  result->recall_at_precision_1 = PickThreshold(SweepThreshold(decisions, revisits), 1.0).recall;
}

/// Of the keyframes that see a place of the loaded map, how many were tied to the map.
void JudgeMap(const ReplayRequest& request,
              const std::vector<TrueKeyframe>& keyframes,
              const std::vector<EvaluatedLoop>& loops,
              const Rigid3& T_B_C,
              ReplayResult* result) {
  const LoopCriteria criteria = request.revisits.value_or(LoopCriteria{});
  std::vector<bool> is_found(keyframes.size(), false);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (loops[i].old < result->map_keyframes && result->score->is_correct[i]) {
      is_found[static_cast<std::size_t>(loops[i].current)] = true;
    }
  }
  const auto map_end = static_cast<std::size_t>(result->map_keyframes);
  for (std::size_t current = map_end; current < keyframes.size(); ++current) {
    bool is_revisit = false;
    for (std::size_t old = 0; old < map_end && !is_revisit; ++old) {
      is_revisit = result->keyframes[old].is_place &&
                   IsRevisit(keyframes[current], keyframes[old], T_B_C, criteria);
    }
    result->map_revisits += is_revisit ? 1 : 0;
    result->map_revisits_found += is_revisit && is_found[current] ? 1 : 0;
  }
  if (map_end > 0) {
    std::vector<TrueKeyframe> places;
    for (std::size_t old = 0; old < map_end; ++old) {
      if (result->keyframes[old].is_place) {
        places.push_back(keyframes[old]);
      }
    }
    const auto first = static_cast<std::ptrdiff_t>(map_end);
    result->relocalisation = MakeRelocalisationCurve(places,
                                                     {keyframes.begin() + first, keyframes.end()},
                                                     {is_found.begin() + first, is_found.end()},
                                                     T_B_C);
  }
}

nlohmann::ordered_json BinsToJson(const std::vector<RelocalisationBin>& bins) {
  auto json = nlohmann::ordered_json::array();
  for (const RelocalisationBin& bin : bins) {
    json.push_back(
        {{"from", bin.from}, {"to", bin.to}, {"keyframes", bin.keyframes}, {"found", bin.found}});
  }
  return json;
}

}  // namespace

void JudgeReplay(const ReplayRequest& request, const Rigid3& T_B_C, ReplayResult* result) {
  const Trajectory truth = ReadTum(request.groundtruth);
  Trajectory map_truth;
  if (!request.map_groundtruth.empty()) {
    map_truth = ReadTum(request.map_groundtruth);
  }
  constexpr std::int64_t kMaxGapNs = 100'000'000;
  std::vector<TrueKeyframe> keyframes;
  Paired own;
  Paired map;
  for (const KeyframeInfo& info : result->keyframes) {
    TrueKeyframe keyframe;
    keyframe.stamp_ns = info.stamp_ns;
    keyframe.is_old_only = info.index < result->map_keyframes;
    keyframe.T_truth_B = (keyframe.is_old_only ? map_truth : truth).At(info.stamp_ns, kMaxGapNs);
    keyframes.push_back(keyframe);
    if (keyframe.T_truth_B) {
      Paired& paired = keyframe.is_old_only ? map : own;
      paired.truth.push_back(keyframe.T_truth_B->t);
      paired.corrected.push_back(info.T_M_B.t);
      paired.vio.push_back(info.T_W_B.t);
    }
  }
  std::vector<EvaluatedLoop> loops;
  std::vector<bool> is_virtual;
  for (const LoopRow& loop : result->loops) {
    if (loop.accepted()) {
      loops.push_back({loop.old, loop.current, loop.T_Bold_Bcurrent});
      is_virtual.push_back(loop.is_virtual);
    }
  }
  result->score = ScoreLoops(keyframes, loops, T_B_C);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    result->virtual_loops += is_virtual[i] ? 1 : 0;
    result->virtual_correct += is_virtual[i] && result->score->is_correct[i] ? 1 : 0;
  }
  JudgeMap(request, keyframes, loops, T_B_C, result);
  SweepScores(request, keyframes, T_B_C, result);
  if (own.truth.size() >= 3) {
    result->ape = ComputeApe(own.truth, own.corrected);
    result->vio_ape = ComputeApe(own.truth, own.vio);
  }
  if (map.truth.size() >= 3 && !own.truth.empty()) {
    const Rigid3 T_truth_M = ComputeApe(map.truth, map.corrected).T_truth_estimate;
    for (Eigen::Vector3d& p : own.corrected) {
      p = T_truth_M * p;
    }
    result->map_frame_ape = ComputeApeUnaligned(own.truth, own.corrected);
  }
}

nlohmann::ordered_json ToJson(const ReplayResult& r) {
  nlohmann::ordered_json json;
  const auto statistic =
      [&](const char* key, const std::optional<ApeStatistics>& ape, double ApeStatistics::*member) {
        json[key] = ape ? nlohmann::ordered_json((*ape).*member) : nlohmann::ordered_json(nullptr);
      };
  const auto accepted =
      std::count_if(r.loops.begin(), r.loops.end(), [](const LoopRow& l) { return l.accepted(); });
  json["keyframes"] = static_cast<int>(r.keyframes.size()) - r.map_keyframes;
  json["map_keyframes"] = r.map_keyframes;
  json["places"] = r.places;
  json["revisits"] = r.score ? nlohmann::ordered_json(r.score->revisits) : nullptr;
  json["loops_accepted"] = accepted;
  json["loops_correct"] = r.score ? nlohmann::ordered_json(r.score->correct) : nullptr;
  json["precision"] = r.score ? nlohmann::ordered_json(r.score->precision()) : nullptr;
  json["recall"] = r.score ? nlohmann::ordered_json(r.score->recall()) : nullptr;
  json["loops_virtual"] = r.virtual_loops;
  json["loops_virtual_correct"] = r.score ? nlohmann::ordered_json(r.virtual_correct) : nullptr;
  json["map_revisits"] = r.map_revisits;
  json["map_recall"] = r.map_revisits > 0
                           ? nlohmann::ordered_json(1.0 * r.map_revisits_found / r.map_revisits)
                           : nlohmann::ordered_json(nullptr);
  json["relocalisation"] = nullptr;
  if (r.relocalisation) {
    json["relocalisation"] = {{"by_distance_m", BinsToJson(r.relocalisation->by_distance)},
                              {"by_angle_deg", BinsToJson(r.relocalisation->by_angle)}};
  }
  const SweepPoint detection = PickThreshold(r.detections, 1.0);
  const bool is_detecting = detection.found > 0;
  json["recall_at_precision_1"] =
      r.score ? nlohmann::ordered_json(r.recall_at_precision_1) : nlohmann::ordered_json(nullptr);
  json["detection_recall_at_precision_1"] =
      r.score ? nlohmann::ordered_json(detection.recall) : nlohmann::ordered_json(nullptr);
  json["detection_r"] =
      is_detecting ? nlohmann::ordered_json(detection.r) : nlohmann::ordered_json(nullptr);
  statistic("ape_mean_m", r.ape, &ApeStatistics::mean);
  statistic("ape_rmse_m", r.ape, &ApeStatistics::rmse);
  statistic("ape_max_m", r.ape, &ApeStatistics::max);
  statistic("ape_min_m", r.ape, &ApeStatistics::min);
  statistic("ape_median_m", r.ape, &ApeStatistics::median);
  statistic("vio_ape_mean_m", r.vio_ape, &ApeStatistics::mean);
  statistic("vio_ape_rmse_m", r.vio_ape, &ApeStatistics::rmse);
  statistic("vio_ape_max_m", r.vio_ape, &ApeStatistics::max);
  statistic("map_frame_ape_mean_m", r.map_frame_ape, &ApeStatistics::mean);
  statistic("map_frame_ape_rmse_m", r.map_frame_ape, &ApeStatistics::rmse);
  json["cpu_s"] = r.cpu_s;
  json["wall_s"] = r.wall_s;
  json["peak_rss_mb"] = r.peak_rss_mb;
  json["core_memory_mb"] = r.core_memory_mb;
  json["views"] = {{"received", r.views.received},
                   {"kept", r.views.kept},
                   {"waiting", r.views.waiting},
                   {"duplicates", r.views.duplicates},
                   {"refused", r.views.refused},
                   {"no_keyframe", r.views.no_keyframe},
                   {"no_place", r.views.no_place},
                   {"uncertain", r.views.uncertain},
                   {"disagree", r.views.disagree},
                   {"surpassed", r.views.surpassed},
                   {"memory_kb_each", r.view_memory_kb}};
  json["features_ms"] = r.mean_times.features;
  json["words_ms"] = r.mean_times.words;
  json["query_ms"] = r.mean_times.query;
  json["verification_ms"] = r.mean_times.verification;
  json["graph_ms"] = r.mean_times.graph;
  json["slowest_keyframe_ms"] = r.slowest_keyframe_ms;
  json["problems"] = r.problems.size();
  nlohmann::ordered_json reasons;
  for (int i = 0; i < kRejectReasonCount; ++i) {
    const auto reason = static_cast<RejectReason>(i);
    reasons[ToString(reason)] = std::count_if(
        r.loops.begin(), r.loops.end(), [&](const LoopRow& l) { return l.reason == reason; });
  }
  json["reasons"] = reasons;
  return json;
}

}  // namespace deja_view
