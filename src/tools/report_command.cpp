#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/report/figures.hpp"
#include "deja_view/report/html_report.hpp"
#include "deja_view/report/run.hpp"
#include "deja_view/report/summary.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "commands.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

struct ReportRequest {
  std::vector<fs::path> runs;
  fs::path groundtruth;
  fs::path camera;
  fs::path out;
  fs::path json;
  fs::path html;
  fs::path evaluation;                ///< directory that `deja_view evaluate` wrote
  std::vector<std::string> pictures;  ///< CAPTION=FILE
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

void WriteHtml(const ReportRequest& request,
               const std::vector<report::JudgedRun>& runs,
               const nlohmann::ordered_json& evaluation) {
  report::HtmlReport html;
  html.runs = runs;
  html.evaluation = evaluation;
  html.version = DEJA_VIEW_VERSION;
  html.command = request.command;
  for (const fs::path& directory : request.runs) {
    const std::string name = directory.filename().string();
    const bool is_scored = name.rfind("weights_", 0) == 0 || name.rfind("threshold_", 0) == 0;
    if ((is_scored || evaluation.empty()) && fs::exists(directory / "sweep.csv")) {
      html.sweeps.push_back(report::ReadSweep(directory / "sweep.csv", name));
    }
  }
  for (const std::string& picture : request.pictures) {
    const std::size_t sign = picture.find('=');
    if (sign == std::string::npos) {
      ThrowInputError("--picture {}: expected CAPTION=FILE", picture);
    }
    html.pictures.emplace_back(picture.substr(0, sign), picture.substr(sign + 1));
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

/// The arguments as they were given.
std::string Arguments(const CLI::App& sub) {
  std::string text;
  for (const CLI::Option* option : sub.get_options()) {
    for (const std::string& value : option->results()) {
      text += " " + option->get_name() + " " + value;
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
  sub->add_option(
      "--camera", request->camera, "Camera YAML, as VINS-Mono's; needed for the recall");
  sub->add_option("--out", request->out, "Directory for the pictures (SVG)");
  sub->add_option("--json", request->json, "File for the figures of the table");
  sub->add_option("--html", request->html, "File for the whole report as one HTML page");
  sub->add_option("--evaluation",
                  request->evaluation,
                  "Directory that deja_view evaluate wrote: all its variants are runs");
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
