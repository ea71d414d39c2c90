#include "deja_view/base/output_lock.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "common/commands.hpp"
#include "common/problem_lines.hpp"
#include "common/reporting.hpp"
#include "replay/replay.hpp"
#include "replay/replay_judge.hpp"
#include "replay/replay_options.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

void PrintTable(const ReplayResult& r, const Json& json, const ReplayVerdict& verdict) {
  std::cout << fmt::format("keyframes {}  places {}  loops {}{}\n{}",
                           json["keyframes"].get<int>(),
                           r.places,
                           json["loops_accepted"].get<int>(),
                           verdict.loops,
                           verdict.map);
  if (r.views.kept > 0 || r.views.received > 0) {
    std::cout << fmt::format(
        "virtual views: {} received, {} kept, {:.1f} kB each; loops with them {}\n",
        r.views.received,
        r.views.kept,
        r.view_memory_kb,
        json["loops_virtual"].get<int>());
  }
  std::cout << verdict.errors
            << fmt::format(
                   "{:.2f} CPU-s, {:.2f} s, {:.0f} MB peak; per keyframe [ms]: features {:.2f}, "
                   "words {:.2f}, query {:.2f}, verification {:.2f}, graph {:.2f}\n",
                   r.cpu_s,
                   r.wall_s,
                   r.peak_rss_mb,
                   r.mean_times.features,
                   r.mean_times.words,
                   r.mean_times.query,
                   r.mean_times.verification,
                   r.mean_times.graph);
}

// A bag's topic may spoil every message in a way of its own.
void PrintProblems(const std::vector<std::string>& problems, bool is_quiet) {
  const std::vector<std::string> kinds = ProblemLines(problems);
  const std::size_t shown = std::min<std::size_t>(kinds.size(), is_quiet ? 1 : 5);
  for (std::size_t i = 0; i < shown; ++i) {
    std::cerr << "warning: " << kinds[i];
    if (i + 1 == shown && shown < kinds.size()) {
      std::cerr << fmt::format(" (and {} more; the figures count them)", kinds.size() - shown);
    }
    std::cerr << "\n";
  }
}

std::vector<OutputLock> LockOutputs(const ReplayRequest& request) {
  std::vector<OutputLock> locks;
  for (const auto& directory : {request.out, request.save_map}) {
    if (!directory.empty()) {
      locks.push_back(OutputLock::OfDirectory(directory));
    }
  }
  return locks;
}

Json Replay(const ReplayRequest& request) {
  const std::vector<OutputLock> locks = LockOutputs(request);
  const ReplayJudge judge(request);
  const ReplayResult result = RunReplay(request);
  const ReplayVerdict verdict = judge.Judge(result);
  Json json = ToJson(result);
  json.update(verdict.figures);
  PrintTable(result, json, verdict);
  PrintProblems(result.problems, !request.show_progress);
  return json;
}

void AddInputOptions(CLI::App* sub, ReplayRequest* request) {
  sub->add_option("--bag", request->bag, "Bag with images and VINS-Mono's keyframes")->required();
  AddHostOptions(sub, &request->host);
  AddHostPosesOptions(sub, &request->host);
  sub->add_option("--virtual-bag",
                  request->virtual_bag,
                  "Bag with virtual views (/virtual_cam0/frame); without, those of --bag");
  sub->add_option("--camera", request->camera, "Camera YAML of an odometry")->required();
  sub->add_option("--config", request->config, "Loop closer's YAML; defaults without");
  sub->add_option("--set", request->overrides, "Override of the config: group.key=value")
      ->take_all();
  sub->add_option("--vocabulary", request->vocabulary, "Vocabulary; the shipped one without");
  sub->add_option("--groundtruth", request->groundtruth, "True body poses (TUM), to judge by");
  sub->add_option(
      "--map-groundtruth", request->map_groundtruth, "True body poses of the loaded map");
  sub->add_option("--load-map", request->load_map, "Directory of a saved map to start from");
  sub->add_option("--start", request->start_s, "Seconds of the flight to leave out")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--duration", request->duration_s, "Seconds of the flight to use; 0: all")
      ->check(CLI::NonNegativeNumber);
}

/// Options that set options of the loop closer, and what is judged.
void AddShortcuts(CLI::App* sub, ReplayRequest* request) {
  sub->add_option_function<double>(
      "--map-spacing",
      [request](double spacing) {
        request->overrides.push_back(fmt::format("map_spacing_m={}", spacing));
      },
      "Keep a keyframe as a place only when none is within so many metres (and 30 degrees)");
  sub->add_option_function<std::string>(
         "--virtual",
         [request](const std::string& value) { request->use_virtual_views = value == "on"; },
         "Use the virtual views of the bag and of the loaded map: on (default) or off")
      ->check(CLI::IsMember({"on", "off"}));
  sub->add_flag_callback(
      "--localise",
      [request] { request->overrides.emplace_back("add_places=false"); },
      "Only look for the loaded map's places");
  sub->add_option_function<std::vector<double>>(
         "--revisit",
         [request](const std::vector<double>& limits) {
           request->map_revisit = RevisitLimits{limits[0], limits[1]};
         },
         "What counts as seeing a place of the loaded map again: metres, degrees (2 40)")
      ->expected(2);
}

}  // namespace

void AddReplayInput(CLI::App* sub, ReplayRequest* request) {
  AddInputOptions(sub, request);
  AddShortcuts(sub, request);
}

void AddReplayCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<ReplayRequest>();
  auto json_file = std::make_shared<std::string>();
  CLI::App* sub =
      app.add_subcommand("replay", "Close loops over a bag of VINS-Mono's topics at full speed");
  AddReplayInput(sub, request.get());
  sub->add_option("--save-map", request->save_map, "Directory to save the map to");
  sub->add_option("--out", request->out, "Directory for trajectory.txt, vio.txt and loops.csv");
  sub->add_option("--json", *json_file, "File for the results");
  AddQuietOption(sub, &request->show_progress);
  sub->footer(
      "Example:\n  deja_view replay --bag hall.bag --camera euroc.yaml --groundtruth truth.txt "
      "--out out");
  sub->callback([=] {
    *command = [=] {
      const Json json = Replay(*request);
      WriteJson(*json_file, json);
      return 0;
    };
  });
}

}  // namespace deja_view
