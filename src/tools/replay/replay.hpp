#pragma once

#include "deja_view/fusion/match_samples.hpp"
#include "deja_view/pipeline/loop_closer.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/host_choice.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// How near a keyframe must come to see a place again.
struct RevisitLimits {
  double distance_m = 0;  ///< between the bodies
  double angle_deg = 0;   ///< between the viewing directions
};

/// Two keyframes, by their stamps.
struct AskedPair {
  std::int64_t current_ns = 0;
  std::int64_t old_ns = 0;
};

/// What `deja_view replay` is told.
struct ReplayRequest {
  std::filesystem::path bag;
  std::filesystem::path virtual_bag;  ///< with /virtual_cam0/frame; empty: the bag's own
  HostChoice host;
  std::filesystem::path camera;           ///< of ReadVinsConfig
  std::filesystem::path config;           ///< LoopFusionOptions; empty: defaults
  std::filesystem::path vocabulary;       ///< empty: the shipped one for the configured descriptor
  std::filesystem::path groundtruth;      ///< TUM; empty: none
  std::filesystem::path map_groundtruth;  ///< TUM of the loaded map; empty: none
  std::filesystem::path load_map;
  std::filesystem::path save_map;
  std::filesystem::path out;
  std::vector<std::string> overrides;  ///< "group.key=value" on top of the config
  double start_s = 0;                  ///< of the flight that is used, after its first keyframe
  double duration_s = 0;               ///< 0: to its end
  bool use_virtual_views = true;       ///< the bag's /virtual_cam0/frame and the loaded map's
  std::optional<RevisitLimits> map_revisit;  ///< of a loaded map's places; default: as everywhere
  std::optional<AskedPair> pair;             ///< to be explained
  bool show_progress = true;
};

/// What a replay found.
struct ReplayResult {
  std::vector<KeyframeInfo> keyframes;  ///< the loaded map's first
  int map_keyframes = 0;                ///< how many of them are the loaded map's
  std::vector<LoopReport> loops;        ///< in the order in which they were decided
  MatchSamples matches;                 ///< of some of them
  std::optional<PairExplanation> explanation;
  /// Per keyframe with something to be matched with: (current, best past keyframe, score).
  struct Best {
    int current = -1;
    BestPlace place;
  };
  std::vector<Best> best_places;
  std::vector<std::string> problems;  ///< messages and keyframes that could not be used
  ReplayReport bag;
  int places = 0;
  int joins_taken_back = 0;  ///< how often the flight had been joined wrongly to another world
  double core_memory_mb = 0;
  double cpu_s = 0;
  double wall_s = 0;
  double peak_rss_mb = 0;
  KeyframeTimes mean_times;  ///< [ms] per keyframe
  double slowest_keyframe_ms = 0;
  ViewCounts views;
  double view_memory_kb = 0;  ///< per view kept, with its part of the index
};

/// Runs LoopCloser over a bag and writes its results to `request.out`. Throws InputError for bad
/// input, and for a bag of which no keyframe can be used.
ReplayResult RunReplay(const ReplayRequest& request);

/// The documented JSON keys; those that need the truth are null, or count nothing, until a
/// ReplayJudge fills them in.
nlohmann::ordered_json ToJson(const ReplayResult& result);

/// The file in the package's config/vocabulary for this descriptor. Looks beside the source tree
/// that this was built from, then in the installed share directory, then in $DEJA_VIEW_SHARE.
std::filesystem::path DefaultVocabulary(const std::string& descriptor_name);

}  // namespace deja_view
