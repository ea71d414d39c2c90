#pragma once

#include "deja_view/evaluation/ape.hpp"
#include "deja_view/evaluation/loop_score.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/pipeline/loop_closer.hpp"
#include "deja_view/ros/bag_replay.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view replay` is told.
struct ReplayRequest {
  std::filesystem::path bag;
  std::filesystem::path camera;           ///< VINS-Mono's YAML
  std::filesystem::path config;           ///< LoopFusionOptions; empty: defaults
  std::filesystem::path vocabulary;       ///< empty: the shipped one for the configured descriptor
  std::filesystem::path groundtruth;      ///< TUM; empty: none
  std::filesystem::path map_groundtruth;  ///< TUM of the loaded map; empty: none
  std::filesystem::path load_map;
  std::filesystem::path save_map;
  std::filesystem::path out;
  std::vector<std::string> overrides;  ///< "group.key=value" on top of the config
  bool show_progress = true;
};

/// One verified candidate, as it goes to loops.csv.
using LoopRow = LoopReport;

/// What a replay found.
struct ReplayResult {
  std::vector<KeyframeInfo> keyframes;  ///< the loaded map's first
  int map_keyframes = 0;                ///< how many of them are the loaded map's
  std::vector<LoopRow> loops;           ///< in the order in which they were decided
  std::vector<std::string> problems;    ///< messages and keyframes that could not be used
  ReplayReport bag;
  int places = 0;
  double core_memory_mb = 0;
  double cpu_s = 0;
  double wall_s = 0;
  double peak_rss_mb = 0;
  KeyframeTimes mean_times;  ///< [ms] per keyframe
  double slowest_keyframe_ms = 0;
  // With ground truth.
  std::optional<LoopScore> score;
  std::optional<ApeStatistics> ape;
  std::optional<ApeStatistics> vio_ape;
  std::optional<ApeStatistics>
      map_frame_ape;  ///< in the loaded map's frame, aligned by the map alone
};

/// Runs LoopCloser over a bag and judges the result. Throws InputError for bad input.
ReplayResult RunReplay(const ReplayRequest& request);

/// The documented JSON keys; null where there is no ground truth.
nlohmann::ordered_json ToJson(const ReplayResult& result);

/// The file in the package's config/vocabulary for this descriptor. Looks beside the source tree
/// that this was built from, then in the installed share directory, then in $DEJA_VIEW_SHARE.
std::filesystem::path DefaultVocabulary(const std::string& descriptor_name);

}  // namespace deja_view
