#pragma once

#include "deja_view/lab/report/matches.hpp"
#include "deja_view/lab/report/run.hpp"
#include "deja_view/lab/report/sweep.hpp"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view::report {

/// Accepted loops so far over time, a line per run (the paper's Figs. 7 and 8). At least one run.
std::string LoopCountFigure(const std::vector<JudgedRun>& runs);

/// When loops were detected, a row per run (the paper's Figs. 7 and 8): with the colour of both for
/// keyframes with a loop in the run before it, too, and with one of its own for further ones. At
/// least one run.
std::string DetectionFigure(const std::vector<JudgedRun>& runs);

/// Maximum, RMSE, mean, median and minimum of the position error, a group of bars per run, the
/// first run's odometry first (the paper's Figs. 12, 13, 17 and 18). At least one run; empty
/// without truth.
std::string ApeFigure(const std::vector<JudgedRun>& runs);

/// Recall over the distance between the map's places, with and without virtual views, from the
/// variants "spacing_M_virtual" and "spacing_M_no_virtual" of an evaluation; empty without any.
std::string SpacingFigure(const nlohmann::ordered_json& variants);

/// What an HTML report shows; all but `runs` may be empty.
struct HtmlReport {
  std::string title = "Loop closure report";
  std::vector<JudgedRun> runs;  ///< the first ones are drawn in full
  /// Those named weights_... are compared with each other, and the others with each other.
  std::vector<Sweep> sweeps;
  /// Caption and rows, the first of which is the head, of further tables.
  std::vector<std::pair<std::string, std::vector<std::vector<std::string>>>> tables;
  nlohmann::ordered_json evaluation;              ///< what `deja_view evaluate` wrote
  std::vector<std::vector<MatchedLoop>> matches;  ///< of each run, to be drawn
  Pictures match_pictures;                        ///< what `matches` show
  /// Caption and PNG or JPEG file of further images.
  std::vector<std::pair<std::string, std::filesystem::path>> pictures;
  std::string version;                ///< of the program and what it was built with
  std::vector<std::string> commands;  ///< that made the runs
  std::string command;                ///< that made the report
};

/// The report as one HTML page that needs nothing else: no network, no script; pictures are inside.
/// Light or dark as the reader's system, and readable on a phone. Throws InputError for a picture
/// that can't be read.
std::string ToHtml(const HtmlReport& report);

}  // namespace deja_view::report
