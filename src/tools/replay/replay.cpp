#include "replay/replay.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/fusion/loop_fusion_options.hpp"
#include "deja_view/fusion/result_files.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/vins_config.hpp"

#include <algorithm>
#include <limits>

#include "common/problem_lines.hpp"
#include "common/shared_files.hpp"
#include "common/tool_figures.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

LoopFusionOptions ReadLoopFusionOptions(const ReplayRequest& request) {
  LoopFusionOptions options;
  ReadOptions(request.config, request.overrides, &options);
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

/// The part of a flight that is asked for.
class FlightPart {
 public:
  explicit FlightPart(const ReplayRequest& request)
      : start_s_(request.start_s),
        end_s_(request.duration_s > 0 ? request.start_s + request.duration_s
                                      : std::numeric_limits<double>::infinity()) {}

  bool Holds(std::int64_t stamp_ns) {
    first_ns_ = first_ns_.value_or(stamp_ns);
    const double since_s = 1e-9 * static_cast<double>(stamp_ns - *first_ns_);
    return since_s >= start_s_ && since_s < end_s_;
  }

 private:
  double start_s_;
  double end_s_;
  std::optional<std::int64_t> first_ns_;
};

void Play(const ReplayRequest& request,
          const LoopFusionOptions& options,
          LoopCloser* closer,
          ReplayResult* result) {
  Progress progress("replay", "messages", 0);
  int accepted = 0;
  FlightPart part(request);
  ReplayCallbacks callbacks;
  callbacks.on_extrinsic = [&](const Rigid3& T_B_C) { closer->SetExtrinsic(T_B_C); };
  callbacks.on_keyframe = [&](const KeyframeInput& input) {
    if (!part.Holds(input.stamp_ns)) {
      return;
    }
    const KeyframeReport report = closer->AddKeyframe(input);
    for (const LoopReport& loop : report.loops) {
      accepted += loop.accepted() ? 1 : 0;
    }
    AddLoopRows(report.loops, &result->loops);
    result->joins_taken_back += report.separates ? 1 : 0;
    if (report.explanation) {
      result->explanation = report.explanation;
    }
    for (const LoopMatches& matches : report.matches) {
      result->matches.Add(matches);
    }
    if (report.best_place) {
      result->best_places.push_back({report.index, *report.best_place});
    }
    AddTimes(report.times, result);
  };
  if (request.start_s == 0) {  // they count the keyframes from the first
    callbacks.on_relative_pose = [&](const RelativePoseUpdate& update) {
      closer->UpdateLoop(update.current, update.T_Bold_Bcurrent);
    };
  }
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
  callbacks.image_size = {vins.camera->width(), vins.camera->height()};
  result->bag = ReplayBag(request.bag,
                          request.virtual_bag,
                          request.host.Topics(vins, request.camera),
                          options.assembler,
                          callbacks,
                          request.host.FrontEnd(vins, options.front_end),
                          request.host.Poses(vins, request.bag));
  if (request.show_progress) {
    progress.Finish(static_cast<std::size_t>(result->bag.messages),
                    fmt::format("{} loops", accepted));
  }
}

void RequireKeyframes(const ReplayRequest& request,
                      const LoopCloser& closer,
                      const ReplayResult& result) {
  if (closer.keyframe_count() == result.map_keyframes) {
    ThrowInputError("{}: no keyframe could be used{}{}",
                    request.bag.string(),
                    result.problems.empty() ? "" : ": ",
                    fmt::join(ProblemLines(result.problems), "; "));
  }
}

}  // namespace

fs::path DefaultVocabulary(const std::string& descriptor_name) {
  return FindSharedFile("vocabulary/" + descriptor_name + ".dvv");
}

ReplayResult RunReplay(const ReplayRequest& request) {
  const double cpu_s_before = CpuSeconds();
  const auto start = Clock::now();
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
  if (request.pair) {
    constexpr std::int64_t kWithin_ns = 20'000'000;  // keyframes are farther apart
    closer.Ask(request.pair->current_ns, request.pair->old_ns, kWithin_ns);
  }
  Play(request, options, &closer, &result);
  RequireKeyframes(request, closer, result);
  AddLoopRows(closer.OptimizeFully(), &result.loops);
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
  result.cpu_s = CpuSeconds() - cpu_s_before;
  result.peak_rss_mb = PeakRssMb();
  result.wall_s = SecondsSince(start);
  if (!request.out.empty()) {
    LoopRows rows;
    for (const LoopReport& loop : result.loops) {
      rows.Add(loop);
    }
    WriteResultFiles(
        request.out, result.keyframes, result.map_keyframes, rows, result.matches.Sorted());
  }
  return result;
}

}  // namespace deja_view
