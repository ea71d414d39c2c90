#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/report/figures.hpp"
#include "deja_view/report/run.hpp"
#include "deja_view/report/summary.hpp"

#include <filesystem>
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
};

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

int RunReport(const ReportRequest& request) {
  const std::vector<report::JudgedRun> runs = ReadRuns(request);
  std::cout << report::SummaryTable(runs);
  if (!request.json.empty()) {
    WriteText(request.json, report::SummaryJson(runs).dump(2) + "\n");
  }
  if (!request.out.empty()) {
    std::cout << "\n";
    for (const fs::path& file : WriteFigures(runs, request.out)) {
      std::cout << file.string() << "\n";
    }
  }
  return 0;
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
      ->required()
      ->expected(1)
      ->take_all();
  sub->add_option("--groundtruth", request->groundtruth, "True body poses (TUM)");
  sub->add_option(
      "--camera", request->camera, "Camera YAML, as VINS-Mono's; needed for the recall");
  sub->add_option("--out", request->out, "Directory for the pictures (SVG)");
  sub->add_option("--json", request->json, "File for the figures of the table");
  sub->footer(
      "Example:\n  deja_view report --run out --groundtruth truth.txt --camera euroc.yaml --out "
      "pictures");
  sub->callback([=] { *command = [=] { return RunReport(*request); }; });
}

}  // namespace deja_view
