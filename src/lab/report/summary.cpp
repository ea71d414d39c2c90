#include "deja_view/lab/report/summary.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace deja_view::report {
namespace {

struct Statistic {
  const char* label;
  const char* key;
  double ApeStatistics::*value;
};

constexpr Statistic kStatistics[] = {
    {"mean error [m]", "mean", &ApeStatistics::mean},
    {"RMS error [m]", "rmse", &ApeStatistics::rmse},
    {"median error [m]", "median", &ApeStatistics::median},
    {"largest error [m]", "max", &ApeStatistics::max},
    {"smallest error [m]", "min", &ApeStatistics::min},
};

/// Lines up columns: the first to the left, the others to the right.
std::string Format(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], row[i].size());
    }
  }
  std::string text;
  for (const auto& row : rows) {
    text += fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i) {
      text += fmt::format("  {:>{}}", row[i], widths[i]);
    }
    text += "\n";
  }
  return text;
}

std::vector<std::string> ErrorRow(const Statistic& statistic, const std::vector<JudgedRun>& runs) {
  const std::optional<ApeStatistics>& vio = runs.front().vio_ape;
  std::vector<std::string> row = {statistic.label,
                                  vio ? fmt::format("{:.4f}", (*vio).*statistic.value) : "-"};
  for (const JudgedRun& run : runs) {
    if (!run.corrected_ape) {
      row.emplace_back("-");
      continue;
    }
    const double value = (*run.corrected_ape).*statistic.value;
    const double before = vio ? (*vio).*statistic.value : 0;
    row.push_back(before > 0 ? fmt::format("{:.4f} ({:+.0f} %)", value, 100 * (value / before - 1))
                             : fmt::format("{:.4f}", value));
  }
  return row;
}

/// A row whose cells `cell` makes from the runs; the VIO has none.
template <typename Cell>
std::vector<std::string> LoopRow(const char* label,
                                 const std::vector<JudgedRun>& runs,
                                 const Cell& cell) {
  std::vector<std::string> row = {label, "-"};
  for (const JudgedRun& run : runs) {
    row.push_back(cell(run));
  }
  return row;
}

/// "accepted" and the reasons of refusal, with their counts.
std::string Reasons(const JudgedRun& run) {
  std::map<std::string, int> counts;
  for (const LoopRecord& loop : run.run.loops) {
    if (!loop.accepted) {
      ++counts[loop.reason];
    }
  }
  std::string text;
  for (const auto& [reason, count] : counts) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, reason);
  }
  return text.empty() ? "none" : text;
}

}  // namespace

std::string SummaryTable(const std::vector<JudgedRun>& runs) {
  DEJA_VIEW_CHECK(!runs.empty());
  std::vector<std::vector<std::string>> rows = {{"", "odometry alone"}};
  for (const JudgedRun& run : runs) {
    rows.front().push_back(runs.size() == 1 ? "with loops closed" : run.run.name);
  }
  for (const Statistic& statistic : kStatistics) {
    rows.push_back(ErrorRow(statistic, runs));
  }
  rows.push_back(LoopRow(
      "keyframes", runs, [](const JudgedRun& run) { return std::to_string(run.run.vio.size()); }));
  rows.push_back(LoopRow("loops accepted", runs, [](const JudgedRun& run) {
    return std::to_string(run.AcceptedLoops());
  }));
  rows.push_back(LoopRow("of these correct", runs, [](const JudgedRun& run) {
    return run.score ? std::to_string(run.score->correct) : "-";
  }));
  rows.push_back(LoopRow("precision", runs, [](const JudgedRun& run) {
    return run.score ? fmt::format("{:.3f}", run.score->precision()) : "-";
  }));
  rows.push_back(LoopRow("recall", runs, [](const JudgedRun& run) {
    return run.HasRecall() ? fmt::format("{:.3f}", run.score->recall()) : "-";
  }));
  std::string text = Format(rows);
  for (const JudgedRun& run : runs) {
    text += fmt::format(
        "candidates refused{}: {}\n", runs.size() == 1 ? "" : " in " + run.run.name, Reasons(run));
  }
  return text;
}

nlohmann::ordered_json SummaryJson(const std::vector<JudgedRun>& runs) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const JudgedRun& run : runs) {
    nlohmann::ordered_json entry;
    entry["name"] = run.run.name;
    entry["keyframes"] = run.run.vio.size();
    entry["loops_accepted"] = run.AcceptedLoops();
    entry["revisits"] = nullptr;
    entry["loops_correct"] = nullptr;
    entry["precision"] = nullptr;
    entry["recall"] = nullptr;
    if (run.score) {
      entry["loops_correct"] = run.score->correct;
      entry["precision"] = run.score->precision();
    }
    if (run.HasRecall()) {
      entry["revisits"] = run.score->revisits;
      entry["recall"] = run.score->recall();
    }
    for (const auto& [prefix, ape] :
         {std::make_pair("ape_", run.corrected_ape), std::make_pair("vio_ape_", run.vio_ape)}) {
      for (const Statistic& statistic : kStatistics) {
        nlohmann::ordered_json& value = entry[fmt::format("{}{}_m", prefix, statistic.key)];
        if (ape) {
          value = (*ape).*statistic.value;
        }
      }
    }
    json.push_back(entry);
  }
  return json;
}

}  // namespace deja_view::report
