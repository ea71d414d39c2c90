#pragma once

#include "deja_view/report/run.hpp"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view::report {

/// Precision and recall over the threshold r, as `replay --out` leaves them in sweep.csv.
struct Sweep {
  std::string name;
  std::vector<double> r;
  std::vector<double> precision;
  std::vector<double> recall;
};

/// Reads a sweep.csv; throws InputError that names file and line.
Sweep ReadSweep(const std::filesystem::path& path, const std::string& name);

/// Accepted loops so far over time, a line per run (the paper's Figs. 7 and 8). At least one run.
std::string LoopCountFigure(const std::vector<JudgedRun>& runs);

/// Recall over precision of places told by score alone, a line per sweep (the paper's Fig. 20).
std::string SweepFigure(const std::vector<Sweep>& sweeps);

/// Recall over the distance between the map's places, with and without virtual views, from the
/// variants "spacing_M_virtual" and "spacing_M_no_virtual" of an evaluation; empty without any.
std::string SpacingFigure(const nlohmann::ordered_json& variants);

/// What an HTML report shows; all but `runs` may be empty.
struct HtmlReport {
  std::string title = "Loop closure report";
  std::vector<JudgedRun> runs;  ///< the first ones are drawn in full
  std::vector<Sweep> sweeps;
  nlohmann::ordered_json evaluation;  ///< what `deja_view evaluate` wrote
  /// Caption and PNG or JPEG file of matched images.
  std::vector<std::pair<std::string, std::filesystem::path>> pictures;
  std::string version;
  std::string command;  ///< that made the report
};

/// The report as one HTML page that needs nothing else: no network, no script; pictures are inside.
/// Light or dark as the reader's system, and readable on a phone. Throws InputError for a picture
/// that can't be read.
std::string ToHtml(const HtmlReport& report);

}  // namespace deja_view::report
