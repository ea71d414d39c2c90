#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/lab/report/figures.hpp"
#include "deja_view/lab/report/html_report.hpp"
#include "deja_view/lab/report/run.hpp"
#include "deja_view/lab/report/summary.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/commands.hpp"
#include <Eigen/Core>
#include <fmt/format.h>
#include <opencv2/core/version.hpp>
#ifdef DEJA_VIEW_WITH_ROS
#include "report/report_pictures.hpp"
#endif

namespace deja_view {
namespace {

namespace fs = std::filesystem;

#ifdef DEJA_VIEW_WITH_ROS
constexpr bool kWithRos = true;
#else
constexpr bool kWithRos = false;
#endif

struct ReportRequest {
  std::vector<fs::path> runs;
  fs::path groundtruth;
  fs::path camera;
  fs::path out;
  fs::path json;
  fs::path html;
  fs::path evaluation;                ///< directory that `deja_view evaluate` wrote
  std::vector<fs::path> sweeps;       ///< runs of which only the scores are shown
  std::vector<std::string> pictures;  ///< CAPTION=FILE
  std::vector<fs::path> bags;         ///< with the images of matched loops
  std::vector<std::string> commands;  ///< that made the runs
  std::vector<std::string> tables;    ///< CAPTION=FILE
  std::string title;                  ///< empty: the usual one
  std::string command;
};

/// Variants of an evaluation that are shown as runs: with and without views first.
void AddEvaluatedRuns(const fs::path& directory,
                      const nlohmann::ordered_json& evaluation,
                      std::vector<fs::path>* runs) {
  for (const auto& entry : evaluation.at("variants")) {
    runs->push_back(directory / entry.at("name").get<std::string>());
  }
  const auto rank = [](const fs::path& path) {
    const std::string name = path.filename().string();
    const bool is_virtual = name.rfind("virtual", 0) == 0;
    return name == "no_virtual" ? 0 : is_virtual ? 1 : 2;
  };
  std::stable_sort(runs->begin(), runs->end(), [&](const fs::path& a, const fs::path& b) {
    return rank(a) < rank(b);
  });
}

nlohmann::ordered_json ReadEvaluation(const fs::path& directory) {
  const fs::path file = directory / "evaluation.json";
  std::ifstream stream(file);
  auto json = nlohmann::ordered_json::parse(stream, nullptr, false);
  if (!json.is_object() || !json.contains("variants") || !json["variants"].is_array()) {
    ThrowInputError("{}: expected what `deja_view evaluate` writes", file.string());
  }
  return json;
}

/// The program, what it was built with, and where it runs.
std::string Version() {
  std::string processor = "unknown processor";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      processor = line.substr(colon + 2);
      break;
    }
  }
  return fmt::format("{}, {}compiler {}, OpenCV {}, Eigen {}.{}.{}; {}, {} threads",
                     DEJA_VIEW_VERSION,
                     kWithRos ? "" : "without ROS, ",
                     __VERSION__,
                     CV_VERSION,
                     EIGEN_WORLD_VERSION,
                     EIGEN_MAJOR_VERSION,
                     EIGEN_MINOR_VERSION,
                     processor,
                     std::thread::hardware_concurrency());
}

std::pair<std::string, fs::path> SplitCaption(const char* option, const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos) {
    ThrowInputError("{} {}: expected CAPTION=FILE", option, text);
  }
  return {text.substr(0, sign), text.substr(sign + 1)};
}

/// A JSON array of arrays of texts and numbers: the head and the rows of a table.
std::vector<std::vector<std::string>> ReadTable(const fs::path& file) {
  std::ifstream stream(file);
  const auto json = nlohmann::json::parse(stream, nullptr, false);
  std::vector<std::vector<std::string>> rows;
  bool is_table = json.is_array() && !json.empty();
  for (std::size_t i = 0; is_table && i < json.size(); ++i) {
    is_table = json[i].is_array();
    rows.emplace_back();
    for (const auto& cell : json[i]) {
      rows.back().push_back(cell.is_string() ? cell.get<std::string>() : cell.dump());
    }
  }
  if (!is_table) {
    ThrowInputError("{}: expected a JSON array with an array per row", file.string());
  }
  return rows;
}

/// Chooses the loops of every run that are shown, and looks their images up.
void AddMatches(const ReportRequest& request, report::HtmlReport* html) {
  constexpr std::size_t kPerRun = 4;
  constexpr std::size_t kRuns = 2;
  std::set<std::pair<std::int64_t, int>> wanted;
  for (std::size_t i = 0; i < std::min(kRuns, request.runs.size()); ++i) {
    const fs::path file = request.runs[i] / "matches.csv";
    html->matches.emplace_back();
    if (fs::exists(file)) {
      html->matches.back() = report::ChooseMatches(report::ReadMatches(file), kPerRun);
    }
    for (const report::MatchedLoop& loop : html->matches.back()) {
      for (const auto& picture : report::PicturesOf(loop)) {
        wanted.insert(picture);
      }
    }
  }
#ifdef DEJA_VIEW_WITH_ROS
  if (!request.bags.empty()) {
    html->match_pictures = ReadPictures(
        request.bags, RequireImageTopic(ReadVinsConfig(request.camera), request.camera), wanted);
  }
#endif
}

void WriteHtml(const ReportRequest& request,
               const std::vector<report::JudgedRun>& runs,
               const nlohmann::ordered_json& evaluation) {
  report::HtmlReport html;
  html.title = request.title.empty() ? html.title : request.title;
  html.runs = runs;
  html.evaluation = evaluation;
  html.version = Version();
  html.commands = request.commands;
  html.command = request.command;
  AddMatches(request, &html);
  for (const fs::path& directory : request.runs) {
    const std::string name = directory.filename().string();
    const bool is_scored = name.rfind("weights_", 0) == 0 || name.rfind("threshold_", 0) == 0;
    if ((is_scored || evaluation.empty()) && fs::exists(directory / "sweep.csv")) {
      html.sweeps.push_back(report::ReadSweep(directory));
    }
  }
  for (const fs::path& directory : request.sweeps) {
    html.sweeps.push_back(report::ReadSweep(directory));
  }
  for (const std::string& picture : request.pictures) {
    html.pictures.push_back(SplitCaption("--picture", picture));
  }
  for (const std::string& table : request.tables) {
    const auto [caption, file] = SplitCaption("--table", table);
    html.tables.emplace_back(caption, ReadTable(file));
  }
  WriteFileAtomically(request.html,
                      [text = report::ToHtml(html)](std::ostream& out) { out << text; });
}

std::vector<report::JudgedRun> ReadRuns(const ReportRequest& request) {
  const Trajectory truth =
      request.groundtruth.empty() ? Trajectory() : ReadTum(request.groundtruth);
  std::optional<Rigid3> T_B_C;
  if (!request.camera.empty()) {
    T_B_C = ReadVinsConfig(request.camera).T_B_C;
  }
  std::vector<report::JudgedRun> runs;
  std::set<std::string> names;
  for (const fs::path& directory : request.runs) {
    runs.push_back(report::Judge(report::ReadRun(directory), truth, T_B_C));
    if (!names.insert(runs.back().run.name).second) {
      ThrowInputError("--run {}: another run is named {} too; names must differ",
                      directory.string(),
                      runs.back().run.name);
    }
  }
  return runs;
}

void WriteText(const fs::path& path, const std::string& text) {
  WriteFileAtomically(path, [&text](std::ostream& out) { out << text; });
}

/// Returns the files that were written.
std::vector<fs::path> WriteFigures(const std::vector<report::JudgedRun>& runs,
                                   const fs::path& out) {
  std::vector<fs::path> files;
  const auto write = [&](const std::string& name, const std::string& svg) {
    files.push_back(out / name);
    WriteText(files.back(), svg);
  };
  for (const report::JudgedRun& run : runs) {
    const std::string prefix = runs.size() == 1 ? "" : run.run.name + "_";
    write(prefix + "trajectory.svg", report::TrajectoryFigure(run));
    write(prefix + "loops.svg", report::LoopFigure(run));
  }
  if (runs.front().vio_ape) {
    write("error.svg", report::ErrorFigure(runs));
  }
  return files;
}

int RunReport(ReportRequest request) {
  nlohmann::ordered_json evaluation;
  if (!request.evaluation.empty()) {
    evaluation = ReadEvaluation(request.evaluation);
    AddEvaluatedRuns(request.evaluation, evaluation, &request.runs);
  }
  if (request.runs.empty()) {
    ThrowInputError("expected --run or --evaluation");
  }
  if (!request.bags.empty() && request.camera.empty()) {
    ThrowInputError("--bag: expected --camera as well, which names the image topic");
  }
  const std::vector<report::JudgedRun> runs = ReadRuns(request);
  std::cout << report::SummaryTable(runs);
  if (!request.json.empty()) {
    WriteText(request.json, report::SummaryJson(runs).dump(2) + "\n");
  }
  if (!request.html.empty()) {
    WriteHtml(request, runs, evaluation);
    std::cout << "\n" << request.html.string() << "\n";
  }
  if (!request.out.empty()) {
    std::cout << "\n";
    for (const fs::path& file : WriteFigures(runs, request.out)) {
      std::cout << file.string() << "\n";
    }
  }
  return 0;
}

/// A word as a shell takes it.
std::string Quoted(const std::string& word) {
  const bool is_plain =
      !word.empty() && word.find_first_of(" \t\n'\"\\$`&|;<>()*?[]#~") == std::string::npos;
  return is_plain ? word : "'" + word + "'";
}

/// The arguments as they were given.
std::string Arguments(const CLI::App& sub) {
  std::string text;
  for (const CLI::Option* option : sub.get_options()) {
    if (option->get_name() == "--ran") {
      continue;  // shown beside this command
    }
    for (const std::string& value : option->results()) {
      text += " " + option->get_name() + " " + Quoted(value);
    }
  }
  return text;
}

}  // namespace

void AddReportCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<ReportRequest>();
  CLI::App* sub = app.add_subcommand("report", "Compare runs with the truth: a table and pictures");
  sub->add_option(
         "--run",
         request->runs,
         "Directory with trajectory.txt, vio.txt and loops.csv, as replay --out or the node "
         "leaves it; can be repeated")
      ->expected(1)
      ->take_all();
  sub->add_option("--groundtruth", request->groundtruth, "True body poses (TUM)");
  sub->add_option("--camera", request->camera, "Camera YAML of an odometry; needed for the recall");
  sub->add_option("--out", request->out, "Directory for the pictures (SVG)");
  sub->add_option("--json", request->json, "File for the figures of the table");
  sub->add_option("--html", request->html, "File for the whole report as one HTML page");
  sub->add_option("--evaluation",
                  request->evaluation,
                  "Directory that deja_view evaluate wrote: all its variants are runs");
#ifdef DEJA_VIEW_WITH_ROS
  sub->add_option("--bag",
                  request->bags,
                  "Bag with the images and virtual views of the runs, to show matched images in "
                  "the HTML page; can be repeated")
      ->take_all();
#endif
  sub->add_option("--sweep",
                  request->sweeps,
                  "Directory of a run with sweep.csv, of which the HTML page shows only how well "
                  "scores alone tell places; can be repeated")
      ->take_all();
  sub->add_option("--ran",
                  request->commands,
                  "A command that made the runs, for the HTML page; can be repeated")
      ->take_all();
  sub->add_option("--title", request->title, "Title of the HTML page");
  sub->add_option("--table",
                  request->tables,
                  "CAPTION=FILE of a further table for the HTML page: a JSON array of rows, the "
                  "head first")
      ->take_all();
  sub->add_option("--picture", request->pictures, "CAPTION=FILE of an image for the HTML page")
      ->take_all();
  sub->footer(
      "Example:\n  deja_view report --run out --groundtruth truth.txt --camera euroc.yaml --out "
      "pictures");
  sub->callback([=] {
    request->command = "deja_view report" + Arguments(*sub);
    *command = [=] { return RunReport(*request); };
  });
}

}  // namespace deja_view
