#include "deja_view/lab/report/html_report.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/report/figures.hpp"
#include "deja_view/lab/report/svg.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "base64.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr std::size_t kRunsInFull = 4;
constexpr std::size_t kMostRuns = 4;  ///< in one figure: each has its colour

// On a narrow screen figures shrink as far as their text can be read; they and tables scroll on
// their own, so that the page need not.
constexpr const char* kPageStyle =
    ":root{color-scheme:light dark;--page:#fff;--text:#1f2328;--muted:#59636e;--line:#d8dde3}\n"
    "@media (prefers-color-scheme:dark){:root{--page:#0d1117;--text:#e6edf3;--muted:#9198a1;"
    "--line:#30363d}}\n"
    "body{margin:0 auto;max-width:1120px;padding:16px;background:var(--page);color:var(--text);"
    "font:15px/1.5 Inter,system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif}\n"
    "h1{font-size:24px}h2{font-size:19px;margin-top:36px}\n"
    "svg.figure,img{max-width:100%;height:auto;display:block}\n"
    "figure{margin:12px 0;overflow-x:auto}\n"
    ".fit>figcaption{display:none}\n"
    "@media (max-width:760px){svg.figure{min-width:720px}.fit>svg.figure{min-width:0}"
    ".fit>figcaption{display:block}.fit text{display:none}}\n"
    "figcaption{color:var(--muted);font-size:13px}\n"
    ".wide{overflow-x:auto}\n"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:13px}\n"
    "th,td{padding:4px 10px;border-bottom:1px solid var(--line);text-align:right;"
    "white-space:nowrap}\n"
    "th:first-child,td:first-child{text-align:left}\n"
    "code{font:12px/1.5 ui-monospace,'DejaVu Sans Mono',monospace;white-space:pre-wrap;"
    "overflow-wrap:anywhere}\n"
    "li{margin:4px 0}\n";

/// An SVG document as a part of the page, whose style sheet it shares. One with a caption shrinks
/// to any screen; where its own text is too small then, the caption stands in for it.
std::string Inline(std::string svg, const std::string& caption = {}) {
  const std::string open = "<style>";
  const std::string close = "</style>\n";
  const std::size_t begin = svg.find(open);
  const std::size_t end = svg.find(close);
  if (begin != std::string::npos && end != std::string::npos) {
    svg.erase(begin, end + close.size() - begin);
  }
  const std::size_t tag = svg.find("<svg ");
  DEJA_VIEW_CHECK(tag != std::string::npos);
  const std::string drawing = svg.substr(tag).insert(5, "class=\"figure\" ");
  return caption.empty() ? "<figure>" + drawing + "</figure>\n"
                         : "<figure class=\"fit\"><figcaption>" + EscapeXml(caption) +
                               "</figcaption>" + drawing + "</figure>\n";
}

std::string PictureFile(const std::string& caption, const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const bool is_png = bytes.rfind("\x89PNG", 0) == 0;
  const bool is_jpeg = bytes.rfind("\xff\xd8", 0) == 0;
  if (!is_png && !is_jpeg) {
    ThrowInputError("{}: expected a PNG or JPEG image", path.string());
  }
  return fmt::format(
      "<figure><img alt=\"{0}\" src=\"data:image/{1};base64,{2}\">"
      "<figcaption>{0}</figcaption></figure>\n",
      EscapeXml(caption),
      is_png ? "png" : "jpeg",
      Base64(bytes));
}

std::string Table(const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"wide\"><table>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const char* cell = i == 0 ? "th" : "td";
    html += "<tr>";
    for (const std::string& text : rows[i]) {
      html += fmt::format("<{0}>{1}</{0}>", cell, EscapeXml(text));
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string Metres(const std::optional<ApeStatistics>& ape, double ApeStatistics::*value) {
  return ape ? fmt::format("{:.4f}", (*ape).*value) : "–";
}

std::vector<std::string> RunRow(const std::string& name,
                                const std::optional<ApeStatistics>& ape,
                                const JudgedRun* run) {
  std::vector<std::string> row = {name};
  for (double ApeStatistics::*value : {&ApeStatistics::mean,
                                       &ApeStatistics::rmse,
                                       &ApeStatistics::median,
                                       &ApeStatistics::max,
                                       &ApeStatistics::min}) {
    row.push_back(Metres(ape, value));
  }
  if (run == nullptr) {
    row.insert(row.end(), 5, "–");
    return row;
  }
  const auto with_views =
      std::count_if(run->run.loops.begin(), run->run.loops.end(), [](const LoopRecord& loop) {
        return loop.accepted && loop.is_virtual;
      });
  row.push_back(std::to_string(run->AcceptedLoops()));
  row.push_back(std::to_string(with_views));
  row.push_back(run->score ? std::to_string(run->score->correct) : "–");
  row.push_back(run->score ? fmt::format("{:.4f}", run->score->precision()) : "–");
  row.push_back(run->HasRecall() ? fmt::format("{:.3f}", run->score->recall()) : "–");
  return row;
}

std::string RunTable(const std::vector<JudgedRun>& runs) {
  std::vector<std::vector<std::string>> rows = {{"run",
                                                 "mean [m]",
                                                 "RMSE [m]",
                                                 "median [m]",
                                                 "max [m]",
                                                 "min [m]",
                                                 "loops",
                                                 "with views",
                                                 "correct",
                                                 "precision",
                                                 "recall"}};
  rows.push_back(RunRow("odometry alone", runs.front().vio_ape, nullptr));
  for (const JudgedRun& run : runs) {
    rows.push_back(RunRow(run.run.name, run.corrected_ape, &run));
  }
  return Table(rows);
}

/// What the variants cost and find, of an evaluation.
std::string VariantTable(const nlohmann::ordered_json& variants) {
  struct Column {
    const char* title;
    const char* key;
    int decimals;
  };
  constexpr Column kColumns[] = {{"loops", "loops_accepted", 0},
                                 {"with views", "loops_virtual", 0},
                                 {"precision", "precision", 4},
                                 {"recall", "recall", 3},
                                 {"recall at precision 1", "recall_at_precision_1", 3},
                                 {"by score alone", "detection_recall_at_precision_1", 3},
                                 {"r", "detection_r", 3},
                                 {"recall of the map", "map_recall", 3},
                                 {"APE mean [m]", "ape_mean_m", 4},
                                 {"APE RMSE [m]", "ape_rmse_m", 4},
                                 {"CPU [s]", "cpu_s", 2},
                                 {"more CPU [%]", "added_cpu_percent", 1},
                                 {"peak RSS [MB]", "peak_rss_mb", 1},
                                 {"more RSS [MB]", "added_rss_mb", 1}};
  std::vector<std::vector<std::string>> rows = {{"variant"}};
  for (const Column& column : kColumns) {
    rows.front().emplace_back(column.title);
  }
  for (const auto& entry : variants) {
    std::vector<std::string> row = {entry.at("name").get<std::string>()};
    for (const Column& column : kColumns) {
      const auto found = entry.find(column.key);
      row.push_back(found == entry.end() || !found->is_number()
                        ? "–"
                        : fmt::format("{:.{}f}", found->get<double>(), column.decimals));
    }
    rows.push_back(std::move(row));
  }
  return Table(rows);
}

std::string Commands(const HtmlReport& report) {
  std::string html = "<h2>How this was made</h2>\n<ul>\n";
  const auto add = [&](const std::string& command) {
    html += "<li><code>" + EscapeXml(command) + "</code></li>\n";
  };
  for (const std::string& command : report.commands) {
    add(command);
  }
  if (report.evaluation.contains("variants")) {
    for (const auto& entry : report.evaluation["variants"]) {
      add(entry.value("command", ""));
    }
  }
  add(report.command);
  return html + fmt::format("</ul>\n<p>déjà view {}</p>\n", EscapeXml(report.version));
}

std::string Figures(const HtmlReport& report) {
  std::vector<JudgedRun> compared(
      report.runs.begin(),
      report.runs.begin() + static_cast<std::ptrdiff_t>(std::min(kMostRuns, report.runs.size())));
  std::string html = "<h2>Trajectories</h2>\n";
  for (std::size_t i = 0; i < std::min(kRunsInFull, compared.size()); ++i) {
    html += "<h3>" + EscapeXml(compared[i].run.name) + "</h3>\n";
    html += Inline(TrajectoryFigure(compared[i]));
  }
  if (compared.front().vio_ape) {
    html += Inline(ErrorFigure(compared)) + Inline(ApeFigure(compared));
  }
  html +=
      "<h2>Loops</h2>\n" + Inline(LoopCountFigure(compared)) + Inline(DetectionFigure(compared));
  for (std::size_t i = 0; i < std::min(kRunsInFull, compared.size()); ++i) {
    html += "<h3>" + EscapeXml(compared[i].run.name) + "</h3>\n" + Inline(LoopFigure(compared[i]));
  }
  return html;
}

std::string Matches(const HtmlReport& report) {
  std::string html;
  for (std::size_t i = 0; i < std::min(report.runs.size(), report.matches.size()); ++i) {
    const RunData& run = report.runs[i].run;
    if (!report.matches[i].empty() && !run.vio.empty()) {
      html += "<h3>" + EscapeXml(run.name) + "</h3>\n";
      for (const MatchedLoop& loop : report.matches[i]) {
        const std::int64_t start_ns = run.vio.stamps_ns.front();
        html +=
            Inline(MatchFigure(loop, report.match_pictures, start_ns), MatchTitle(loop, start_ns));
      }
    }
  }
  for (const auto& [caption, path] : report.pictures) {
    html += PictureFile(caption, path);
  }
  return html.empty() ? html : "<h2>Matched images</h2>\n" + html;
}

/// The threshold r: what it finds, and how ways to weigh words and to compare scores do.
std::string Thresholds(const std::vector<Sweep>& sweeps) {
  std::vector<Sweep> weights;
  std::vector<Sweep> others;
  for (const Sweep& sweep : sweeps) {
    (sweep.name.rfind("weights_", 0) == 0 ? weights : others).push_back(sweep);
  }
  std::string html = "<h2>Thresholds</h2>\n" + Table(ThresholdRows(sweeps));
  const std::vector<Sweep>& shown = others.empty() ? weights : others;
  for (std::size_t i = 0; i < std::min(kRunsInFull, shown.size()); ++i) {
    html += shown[i].detections.empty() ? "" : Inline(ScoreFigure(shown[i]));
  }
  for (const std::vector<Sweep>* group : {&others, &weights}) {
    html += group->empty() ? "" : Inline(SweepFigure(*group)) + Inline(ThresholdFigure(*group));
  }
  return html;
}

}  // namespace

std::string ToHtml(const HtmlReport& report) {
  DEJA_VIEW_CHECK(!report.runs.empty());
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n";
  html +=
      fmt::format("<title>{0}</title>\n<style>\n{1}{2}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
                  EscapeXml(report.title),
                  StyleSheet(),
                  kPageStyle);
  html += RunTable(report.runs);
  for (const auto& [caption, rows] : report.tables) {
    html += "<h2>" + EscapeXml(caption) + "</h2>\n" + Table(rows);
  }
  html += Figures(report) + Matches(report);
  if (!report.sweeps.empty()) {
    html += Thresholds(report.sweeps);
  }
  if (report.evaluation.contains("variants")) {
    const std::string spacing = SpacingFigure(report.evaluation["variants"]);
    html += spacing.empty() ? "" : "<h2>Thinner maps</h2>\n" + Inline(spacing);
    html += "<h2>Variants</h2>\n" + VariantTable(report.evaluation["variants"]);
  }
  return html + Commands(report) + "</body>\n</html>\n";
}

}  // namespace deja_view::report
