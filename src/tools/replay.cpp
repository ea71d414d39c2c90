#include "replay.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/ros/loop_fusion_options.hpp"
#include "deja_view/ros/result_files.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "shared_files.hpp"
#include <fmt/format.h>
#include <sys/resource.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

struct Usage {
  double cpu_s = 0;
  double peak_rss_mb = 0;
};

Usage ProcessUsage() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {seconds(usage.ru_utime) + seconds(usage.ru_stime),
          static_cast<double>(usage.ru_maxrss) / 1024.0};
}

LoopFusionOptions ReadLoopFusionOptions(const ReplayRequest& request) {
  LoopFusionOptions options;
  if (!request.config.empty()) {
    ReadOptions(request.config, &options);
  }
  for (const std::string& assignment : request.overrides) {
    OverrideOption(assignment, &options);
  }
  return options;
}

void AddTimes(const KeyframeTimes& times, ReplayResult* result) {
  KeyframeTimes& sum = result->mean_times;
  sum.features += times.features;
  sum.words += times.words;
  sum.query += times.query;
  sum.verification += times.verification;
  sum.graph += times.graph;
  result->slowest_keyframe_ms = std::max(result->slowest_keyframe_ms, times.total());
}

void DivideTimes(int count, ReplayResult* result) {
  KeyframeTimes& sum = result->mean_times;
  for (double* time : {&sum.features, &sum.words, &sum.query, &sum.verification, &sum.graph}) {
    *time /= std::max(1, count);
  }
}

void Play(const ReplayRequest& request,
          const KeyframeAssemblerOptions& assembler,
          LoopCloser* closer,
          ReplayResult* result) {
  Progress progress("replay", "messages", 0);
  int accepted = 0;
  ReplayCallbacks callbacks;
  callbacks.on_extrinsic = [&](const Rigid3& T_B_C) { closer->SetExtrinsic(T_B_C); };
  callbacks.on_keyframe = [&](const KeyframeInput& input) {
    const KeyframeReport report = closer->AddKeyframe(input);
    for (const LoopReport& loop : report.loops) {
      accepted += loop.accepted() ? 1 : 0;
      result->loops.push_back(loop);
    }
    AddTimes(report.times, result);
  };
  callbacks.on_relative_pose = [&](const RelativePoseUpdate& update) {
    closer->UpdateLoop(update.current, update.T_Bold_Bcurrent);
  };
  callbacks.on_problem = [&](const std::string& what) { result->problems.push_back(what); };
  if (request.show_progress) {
    callbacks.on_progress = [&](std::int64_t done, std::int64_t total) {
      progress.SetTotal(static_cast<std::size_t>(total));
      progress.Update(static_cast<std::size_t>(done), fmt::format("{} loops", accepted));
    };
  }
  const VinsConfig vins = ReadVinsConfig(request.camera);
  VioTopics topics;
  topics.image = vins.image_topic;
  result->bag = ReplayBag(request.bag, topics, assembler, callbacks);
  if (request.show_progress) {
    progress.Finish(static_cast<std::size_t>(result->bag.messages),
                    fmt::format("{} loops", accepted));
  }
}

/// Positions of the session's own keyframes where the truth covers them.
struct Paired {
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> corrected;
  std::vector<Eigen::Vector3d> vio;
};

void Judge(const ReplayRequest& request, const Rigid3& T_B_C, ReplayResult* result) {
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
  for (const LoopRow& loop : result->loops) {
    if (loop.accepted()) {
      loops.push_back({loop.old, loop.current, loop.T_Bold_Bcurrent});
    }
  }
  result->score = ScoreLoops(keyframes, loops, T_B_C);
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

}  // namespace

fs::path DefaultVocabulary(const std::string& descriptor_name) {
  return FindSharedFile("vocabulary/" + descriptor_name + ".dvv");
}

ReplayResult RunReplay(const ReplayRequest& request) {
  const Usage before = ProcessUsage();
  const auto start = std::chrono::steady_clock::now();
  ReplayResult result;
  const LoopFusionOptions options = ReadLoopFusionOptions(request);
  const VinsConfig vins = ReadVinsConfig(request.camera);
  const auto vocabulary = Vocabulary::Open(request.vocabulary.empty() ? DefaultVocabulary("brief")
                                                                      : request.vocabulary);
  LoopCloser closer(options.loop_closer, vins.camera, vins.T_B_C, vocabulary);
  if (!request.load_map.empty()) {
    closer.Load(request.load_map);
    result.map_keyframes = closer.keyframe_count();
  }
  Play(request, options.assembler, &closer, &result);
  closer.OptimizeFully();
  if (!request.save_map.empty()) {
    closer.Save(request.save_map);
  }
  for (int i = 0; i < closer.keyframe_count(); ++i) {
    result.keyframes.push_back(closer.keyframe(i));
  }
  DivideTimes(closer.keyframe_count() - result.map_keyframes, &result);
  result.places = closer.place_count();
  result.core_memory_mb = static_cast<double>(closer.memory_bytes()) / (1024.0 * 1024.0);
  const Usage after = ProcessUsage();
  result.cpu_s = after.cpu_s - before.cpu_s;
  result.peak_rss_mb = after.peak_rss_mb;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!request.groundtruth.empty()) {
    Judge(request, vins.T_B_C, &result);
  }
  if (!request.out.empty()) {
    WriteResultFiles(request.out, result.keyframes, result.map_keyframes, result.loops);
  }
  return result;
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
