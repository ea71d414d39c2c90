#include "replay/replay_judge.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/lab/evaluation/judge.hpp"

#include <optional>
#include <ostream>
#include <vector>

#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Flight ToFlight(const ReplayResult& result) {
  Flight flight;
  for (const KeyframeInfo& info : result.keyframes) {
    FlownKeyframe keyframe;
    keyframe.stamp_ns = info.stamp_ns;
    keyframe.T_M_B = info.T_M_B;
    keyframe.T_W_B = info.T_W_B;
    keyframe.is_of_map = info.index < result.map_keyframes;
    keyframe.is_place = info.is_place;
    flight.keyframes.push_back(keyframe);
  }
  for (const LoopReport& loop : result.loops) {
    flight.loops.push_back({loop.old,
                            loop.current,
                            loop.T_Bold_Bcurrent,
                            loop.score,
                            loop.is_virtual,
                            loop.accepted()});
  }
  for (const ReplayResult::Best& best : result.best_places) {
    flight.detections.push_back({best.place.old, best.current, best.place.score});
  }
  return flight;
}

JudgeOptions MakeJudgeOptions(const ReplayRequest& request) {
  JudgeOptions options;
  if (request.map_revisit) {
    options.map_criteria.revisit_distance_m = request.map_revisit->distance_m;
    options.map_criteria.revisit_angle_deg = request.map_revisit->angle_deg;
  }
  return options;
}

/// "r,found,correct,precision,recall", r falling.
void WriteSweep(const fs::path& path, const std::vector<SweepPoint>& sweep) {
  WriteFileAtomically(path, [&sweep](std::ostream& out) {
    out << "r,found,correct,precision,recall\n";
    for (const SweepPoint& p : sweep) {
      out << fmt::format(
          "{:.9g},{},{},{:.6f},{:.6f}\n", p.r, p.found, p.correct, p.precision, p.recall);
    }
  });
}

/// The places that score best, beside the truth.
void WriteDetections(const fs::path& path,
                     const Flight& flight,
                     const std::vector<std::optional<ScoredDecision>>& decisions) {
  const auto stamp = [&flight](int keyframe) {
    return flight.keyframes[static_cast<std::size_t>(keyframe)].stamp_ns;
  };
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "stamp_current_ns,stamp_old_ns,score,correct,revisit\n";
    for (std::size_t i = 0; i < decisions.size(); ++i) {
      const FlownDetection& detection = flight.detections[i];
      if (decisions[i]) {
        out << fmt::format("{},{},{:.9g},{:d},{:d}\n",
                           stamp(detection.current),
                           stamp(detection.old),
                           detection.score,
                           decisions[i]->is_correct,
                           decisions[i]->is_revisit);
      }
    }
  });
}

Json BinsToJson(const std::vector<RelocalisationBin>& bins) {
  Json json = Json::array();
  for (const RelocalisationBin& bin : bins) {
    json.push_back(
        {{"from", bin.from}, {"to", bin.to}, {"keyframes", bin.keyframes}, {"found", bin.found}});
  }
  return json;
}

double MapRecall(const JudgedFlight& judged) {
  return 1.0 * judged.map_revisits_found / judged.map_revisits;
}

Json Figures(const JudgedFlight& judged) {
  Json json;
  json["revisits"] = judged.score.revisits;
  json["loops_correct"] = judged.score.correct;
  json["precision"] = judged.score.precision();
  json["recall"] = judged.score.recall();
  json["loop_error_max_m"] = judged.score.worst.distance_m;
  json["loop_error_max_deg"] = judged.score.worst.angle_deg;
  json["loops_virtual"] = judged.virtual_loops;
  json["loops_virtual_correct"] = judged.virtual_correct;
  json["map_revisits"] = judged.map_revisits;
  if (judged.map_revisits > 0) {
    json["map_recall"] = MapRecall(judged);
  }
  if (judged.relocalisation) {
    json["relocalisation"] = {{"by_distance_m", BinsToJson(judged.relocalisation->by_distance)},
                              {"by_angle_deg", BinsToJson(judged.relocalisation->by_angle)}};
  }
  const SweepPoint detection = PickThreshold(judged.detections, 1.0);
  json["recall_at_precision_1"] = judged.recall_at_precision_1;
  json["detection_recall_at_precision_1"] = detection.recall;
  if (detection.found > 0) {
    json["detection_r"] = detection.r;
  }
  if (judged.ape) {
    json["ape_mean_m"] = judged.ape->mean;
    json["ape_rmse_m"] = judged.ape->rmse;
    json["ape_max_m"] = judged.ape->max;
    json["ape_min_m"] = judged.ape->min;
    json["ape_median_m"] = judged.ape->median;
    json["vio_ape_mean_m"] = judged.vio_ape->mean;
    json["vio_ape_rmse_m"] = judged.vio_ape->rmse;
    json["vio_ape_max_m"] = judged.vio_ape->max;
  }
  if (judged.map_frame_ape) {
    json["map_frame_ape_mean_m"] = judged.map_frame_ape->mean;
    json["map_frame_ape_rmse_m"] = judged.map_frame_ape->rmse;
  }
  return json;
}

std::string ErrorRow(const char* name, const ApeStatistics& ape) {
  return fmt::format("{:<9} {:>7.4f} {:>7.4f} {:>7.4f} {:>7.4f} {:>7.4f}\n",
                     name,
                     ape.mean,
                     ape.rmse,
                     ape.max,
                     ape.median,
                     ape.min);
}

ReplayVerdict Describe(const JudgedFlight& judged) {
  ReplayVerdict verdict;
  verdict.figures = Figures(judged);
  verdict.loops = fmt::format("  correct {}  precision {:.3f}  recall {:.3f} ({} of {} revisits)",
                              judged.score.correct,
                              judged.score.precision(),
                              judged.score.recall(),
                              judged.score.revisits_found,
                              judged.score.revisits);
  if (judged.map_revisits > 0) {
    verdict.map = fmt::format("places of the map: {} of {} revisits found, {:.3f}\n",
                              judged.map_revisits_found,
                              judged.map_revisits,
                              MapRecall(judged));
  }
  if (judged.ape) {
    verdict.errors = "APE [m]      mean    rmse     max  median     min\n" +
                     ErrorRow("VIO", *judged.vio_ape) + ErrorRow("corrected", *judged.ape);
    if (judged.map_frame_ape) {
      verdict.errors += ErrorRow("in map", *judged.map_frame_ape);
    }
  }
  return verdict;
}

}  // namespace

ReplayJudge::ReplayJudge(const ReplayRequest& request) : request_(request) {
  if (!request.groundtruth.empty()) {
    truth_ = ReadTum(request.groundtruth);
  }
  if (!request.map_groundtruth.empty()) {
    map_truth_ = ReadTum(request.map_groundtruth);
  }
}

ReplayVerdict ReplayJudge::Judge(const ReplayResult& result) const {
  const Flight flight = ToFlight(result);
  JudgedFlight judged;
  ReplayVerdict verdict;
  if (!request_.groundtruth.empty()) {
    judged = JudgeFlight(flight,
                         {truth_, map_truth_},
                         ReadVinsConfig(request_.camera).T_B_C,
                         MakeJudgeOptions(request_));
    verdict = Describe(judged);
  }
  if (!request_.out.empty()) {
    WriteSweep(request_.out / "sweep.csv", judged.detections);
    WriteDetections(request_.out / "detections.csv", flight, judged.decisions);
  }
  return verdict;
}

}  // namespace deja_view
