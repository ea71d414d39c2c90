#include "replay/replay.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/fusion/loop_fusion_options.hpp"
#include "deja_view/fusion/result_files.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/vins_config.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/shared_files.hpp"
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
  if (!request.use_virtual_views) {
    options.loop_closer.views.keep = 0;
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
          const LoopFusionOptions& options,
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
    for (const LoopMatches& matches : report.matches) {
      result->matches.Add(matches);
    }
    if (report.best_place) {
      result->best_places.push_back({report.index, *report.best_place, {}});
    }
    AddTimes(report.times, result);
  };
  callbacks.on_relative_pose = [&](const RelativePoseUpdate& update) {
    closer->UpdateLoop(update.current, update.T_Bold_Bcurrent);
  };
  if (request.use_virtual_views) {
    callbacks.on_virtual_view = [&](const VirtualView& view) { closer->AddVirtualView(view); };
    callbacks.sufficient_features = options.loop_closer.SufficientViewFeatures();
  }
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
  result->bag = ReplayBag(request.bag, request.virtual_bag, topics, options.assembler, callbacks);
  if (request.show_progress) {
    progress.Finish(static_cast<std::size_t>(result->bag.messages),
                    fmt::format("{} loops", accepted));
  }
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
void WriteDetections(const fs::path& path, const ReplayResult& result) {
  const auto stamp = [&result](int keyframe) {
    return result.keyframes[static_cast<std::size_t>(keyframe)].stamp_ns;
  };
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "stamp_current_ns,stamp_old_ns,score,correct,revisit\n";
    for (const ReplayResult::Best& best : result.best_places) {
      if (best.decision) {
        out << fmt::format("{},{},{:.9g},{:d},{:d}\n",
                           stamp(best.current),
                           stamp(best.place.old),
                           best.place.score,
                           best.decision->is_correct,
                           best.decision->is_revisit);
      }
    }
  });
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
  const auto vocabulary =
      Vocabulary::Open(request.vocabulary.empty()
                           ? DefaultVocabulary(EnumToString(options.loop_closer.features.kind))
                           : request.vocabulary);
  LoopCloser closer(options.loop_closer, vins.camera, vins.T_B_C, vocabulary);
  if (!request.load_map.empty()) {
    closer.Load(request.load_map);
    result.map_keyframes = closer.keyframe_count();
  }
  Play(request, options, &closer, &result);
  closer.OptimizeFully();
  if (!request.save_map.empty()) {
    closer.Save(request.save_map);
  }
  for (int i = 0; i < closer.keyframe_count(); ++i) {
    result.keyframes.push_back(closer.keyframe(i));
  }
  DivideTimes(closer.keyframe_count() - result.map_keyframes, &result);
  result.places = closer.place_count();
  result.views = closer.view_counts();
  if (result.views.kept > 0) {
    result.view_memory_kb = static_cast<double>(closer.view_memory_bytes()) / 1024.0 /
                            static_cast<double>(result.views.kept);
  }
  result.core_memory_mb = static_cast<double>(closer.memory_bytes()) / (1024.0 * 1024.0);
  const Usage after = ProcessUsage();
  result.cpu_s = after.cpu_s - before.cpu_s;
  result.peak_rss_mb = after.peak_rss_mb;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!request.groundtruth.empty()) {
    JudgeReplay(request, vins.T_B_C, &result);
  }
  if (!request.out.empty()) {
    WriteResultFiles(
        request.out, result.keyframes, result.map_keyframes, result.loops, result.matches.Sorted());
    WriteSweep(request.out / "sweep.csv", result.detections);
    WriteDetections(request.out / "detections.csv", result);
  }
  return result;
}

}  // namespace deja_view
