#include <algorithm>

#include "replay/replay.hpp"

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

/// What only the truth can tell stands here without a value, so that the keys keep their order.
void AddOpenFigures(const ReplayResult& r, Json* json) {
  const auto accepted = std::count_if(
      r.loops.begin(), r.loops.end(), [](const LoopReport& l) { return l.accepted(); });
  (*json)["revisits"] = nullptr;
  (*json)["loops_accepted"] = accepted;
  (*json)["loops_correct"] = nullptr;
  (*json)["precision"] = nullptr;
  (*json)["recall"] = nullptr;
  (*json)["loops_virtual"] = 0;
  (*json)["loops_virtual_correct"] = nullptr;
  (*json)["map_revisits"] = 0;
  for (const char* key : {"map_recall",
                          "relocalisation",
                          "recall_at_precision_1",
                          "detection_recall_at_precision_1",
                          "detection_r",
                          "ape_mean_m",
                          "ape_rmse_m",
                          "ape_max_m",
                          "ape_min_m",
                          "ape_median_m",
                          "vio_ape_mean_m",
                          "vio_ape_rmse_m",
                          "vio_ape_max_m",
                          "map_frame_ape_mean_m",
                          "map_frame_ape_rmse_m"}) {
    (*json)[key] = nullptr;
  }
}

Json ToJson(const ViewCounts& views, double view_memory_kb) {
  return {{"received", views.received},
          {"kept", views.kept},
          {"waiting", views.waiting},
          {"duplicates", views.duplicates},
          {"refused", views.refused},
          {"no_keyframe", views.no_keyframe},
          {"no_place", views.no_place},
          {"uncertain", views.uncertain},
          {"disagree", views.disagree},
          {"surpassed", views.surpassed},
          {"memory_kb_each", view_memory_kb}};
}

}  // namespace

Json ToJson(const ReplayResult& r) {
  Json json;
  json["keyframes"] = static_cast<int>(r.keyframes.size()) - r.map_keyframes;
  json["map_keyframes"] = r.map_keyframes;
  json["places"] = r.places;
  AddOpenFigures(r, &json);
  json["cpu_s"] = r.cpu_s;
  json["wall_s"] = r.wall_s;
  json["peak_rss_mb"] = r.peak_rss_mb;
  json["core_memory_mb"] = r.core_memory_mb;
  json["views"] = ToJson(r.views, r.view_memory_kb);
  json["features_ms"] = r.mean_times.features;
  json["words_ms"] = r.mean_times.words;
  json["query_ms"] = r.mean_times.query;
  json["verification_ms"] = r.mean_times.verification;
  json["graph_ms"] = r.mean_times.graph;
  json["slowest_keyframe_ms"] = r.slowest_keyframe_ms;
  if (r.bag.front_end.images > 0) {
    json["front_end"] = {{"images", r.bag.front_end.images},
                         {"images_without_pose", r.bag.front_end.without_pose},
                         {"keyframes", r.bag.front_end.keyframes},
                         {"points", r.bag.front_end.points}};
  }
  json["joins_taken_back"] = r.joins_taken_back;
  json["restarts"] = r.bag.assembler.restarts;
  json["problems"] = r.problems.size();
  Json reasons;
  for (int i = 0; i < kRejectReasonCount; ++i) {
    const auto reason = static_cast<RejectReason>(i);
    reasons[EnumToString(reason)] = std::count_if(
        r.loops.begin(), r.loops.end(), [&](const LoopReport& l) { return l.reason == reason; });
  }
  json["reasons"] = reasons;
  return json;
}

}  // namespace deja_view
