#include "deja_view/base/output_lock.hpp"
#include "deja_view/lab/sim/exact_views.hpp"
#include "deja_view/lab/sim/options.hpp"

#include <iostream>
#include <memory>

#include "common/commands.hpp"
#include "common/reporting.hpp"
#include "simulate/simulate_flight.hpp"
#include "simulate/simulate_views.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

void PrintViews(const SimulateRequest& request, const nlohmann::ordered_json& json) {
  std::cout << fmt::format("{}: {} views, {:.1f} s\n",
                           (request.out / "views.bag").string(),
                           json["virtual_views"].get<std::size_t>(),
                           json["wall_s"].get<double>());
}

void PrintFlight(const SimulateRequest& request, const nlohmann::ordered_json& json) {
  std::cout << fmt::format(
      "{}: {} images, {} keyframes with {:.0f} points, path {:.1f} m, drift {:.2f} %, {:.1f} s\n",
      request.out.string(),
      json["images"].get<std::size_t>(),
      json["keyframes"].get<std::size_t>(),
      json["points_per_keyframe"].get<double>(),
      json["path_m"].get<double>(),
      100 * json["drift"].get<double>(),
      json["wall_s"].get<double>());
}

using Request = std::shared_ptr<SimulateRequest>;

void AddFlightOptions(CLI::App* sub, const Request& request) {
  const auto set = [request](const char* key) {
    return [request, key](const std::string& value) {
      request->overrides.push_back(fmt::format("{}={}", key, value));
    };
  };
  sub->add_option("--out", request->out, "Directory for the results")->required();
  // Before the options below, which add to what it sets.
  sub->add_option("--set", request->overrides, "Override of an option: group.key=value")
      ->take_all();
  sub->add_option("--preset", request->preset, "What kind of world")
      ->check(CLI::IsMember(sim::PresetNames()))
      ->capture_default_str();
  sub->add_option_function<std::string>(
         "--seed",
         [request](const std::string& value) {
           request->overrides.insert(request->overrides.begin(),
                                     {"seed=" + value, "flight_seed=" + value});
         },
         "Seed of hall and flight")
      ->check(CLI::NonNegativeNumber);
  sub->add_option_function<std::string>("--flight-seed",
                                        set("flight_seed"),
                                        "Seed of the flight alone: a second session in the hall")
      ->check(CLI::NonNegativeNumber);
  sub->add_option_function<std::string>(
         "--duration", set("flight.duration_s"), "Length of the flight [s]")
      ->check(CLI::PositiveNumber);
  sub->add_option(
      "--config", request->config, "YAML with simulation options, on top of the preset");
}

void AddOutputOptions(CLI::App* sub, const Request& request) {
  sub->add_flag("--bag", request->bag, "Write flight.bag with VINS-Mono's topics (needs ROS)");
  sub->add_option("--images", request->images, "Write images/<stamp>: png, jpg or none")
      ->check(CLI::IsMember({"png", "jpg", "none"}));
  sub->add_flag("--ranges", request->ranges, "Write ranges/<stamp>.png, 16-bit mm along the ray");
  sub->add_option("--virtual-views",
                  request->virtual_views,
                  "Add exact views beside every keyframe to the bag: paper (2 within 2 cm) or wide "
                  "(4 at 0.3 to 0.8 m)")
      ->check(CLI::IsMember(sim::ExactViewPresetNames()));
  sub->add_option("--views-for",
                  request->views_for,
                  "TUM file of a flight simulated before (same seeds or --config): only render the "
                  "views of these stamps, to views.bag");
  sub->add_option("--views-like",
                  request->views_like,
                  "Bag of virtual views of a flight simulated before: only render what is exact at "
                  "their poses, to views.bag")
      ->check(CLI::ExistingFile);
  sub->add_option("--virtual-content", request->virtual_content, "What they hold")
      ->check(CLI::IsMember({"features", "image", "both"}))
      ->capture_default_str();
}

int Simulate(const SimulateRequest& request, const std::string& json_file) {
  const bool only_views = !request.views_for.empty() || !request.views_like.empty();
  const OutputLock lock = OutputLock::OfDirectory(request.out);
  return Report([&] { return only_views ? RunSimulateViews(request) : RunSimulate(request); },
                json_file,
                [&](const nlohmann::ordered_json& json) {
                  (only_views ? PrintViews : PrintFlight)(request, json);
                });
}

}  // namespace

void AddSimulateCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<SimulateRequest>();
  auto json_file = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "simulate", "Fly a simulated drone through a hall, with images, IMU and a drifting VIO");
  AddFlightOptions(sub, request);
  AddOutputOptions(sub, request);
  sub->add_option("--json", *json_file, "File for the figures");
  AddQuietOption(sub, &request->show_progress);
  sub->footer(
      "Writes groundtruth.txt and vio.txt (TUM, body poses), camera.yaml, simulation.yaml.\n"
      "Example:\n  deja_view simulate --preset hall --seed 3 --duration 60 --bag --out flight");
  sub->callback([=] { *command = [=] { return Simulate(*request, *json_file); }; });
}

}  // namespace deja_view
