#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view evaluate` is told.
struct EvaluateRequest {
  std::filesystem::path bag;
  std::filesystem::path camera;
  std::filesystem::path groundtruth;
  std::filesystem::path vocabulary;       ///< empty: the shipped one
  std::filesystem::path config;           ///< empty: defaults
  std::filesystem::path load_map;         ///< empty: none
  std::filesystem::path map_groundtruth;  ///< of the loaded map
  std::vector<double> revisit;            ///< metres, degrees; empty: replay's default
  bool localise = false;                  ///< only look for the loaded map's places
  /// Name and bag of virtual views, each a variant of its own.
  std::vector<std::pair<std::string, std::filesystem::path>> virtual_bags;
  std::vector<double> spacings_m;  ///< [m] of the map, each with and without virtual views
  std::vector<std::pair<std::string, std::string>> extra;  ///< name and further replay arguments
  std::vector<std::string> only;  ///< names of the variants to run; empty: all
  std::filesystem::path out;
  bool show_progress = true;
};

/// One run of `deja_view replay`.
struct Variant {
  std::string name;
  std::vector<std::string> arguments;  ///< beyond those that all variants share
};

/// Without virtual views; with those of the bag, all and the one most like its source; with each of
/// `virtual_bags`; each of the paper's word weights; its thresholds; each map spacing; `extra`.
std::vector<Variant> MakeVariants(const EvaluateRequest& request, bool bag_has_views);

/// Runs every variant in a process of its own, one after the other, so that CPU seconds and peak
/// memory are its own, with results under `out`/NAME. Returns {bag, ..., variants: [{name,
/// arguments, command, replay's keys, added_cpu_percent, added_rss_mb}]}; what is added is against
/// "no_virtual". Throws InputError when a variant fails, Interrupted after Ctrl-C.
nlohmann::ordered_json RunEvaluate(const EvaluateRequest& request);

}  // namespace deja_view
