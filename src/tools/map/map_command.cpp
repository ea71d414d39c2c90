#include "map/map_command.hpp"

#include "deja_view/base/output_lock.hpp"

#include <iostream>
#include <memory>

#include "common/commands.hpp"
#include "common/interrupt.hpp"
#include "common/reporting.hpp"

namespace deja_view {

void AddMapCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<MapRequest>();
  auto json_file = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "map", "Make a map that also recognises the place from where the flight has not been");
  sub->add_option("--bag", request->bag, "Bag with images, and keyframes or poses of an odometry")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--camera", request->camera, "Camera YAML of an odometry")
      ->required()
      ->check(CLI::ExistingFile);
  AddHostOptions(sub, &request->host);
  AddHostPosesOptions(sub, &request->host);
  sub->add_option("--add", request->add, "Directory of a map of the place that is to know more")
      ->check(CLI::ExistingDirectory);
  sub->add_option("--out", request->out, "Directory for map.dvm, field.dvn and what they rest on")
      ->required();
  sub->add_option(
      "--bag-out", request->bag_out, "Bag for the flight with its views on /virtual_cam0/frame");
  sub->add_option("--budget-s", request->budget_s, "Wall time in all [s]")
      ->check(CLI::Range(60.0, 1e6))
      ->capture_default_str();
  sub->add_option("--steps", request->steps, "Of the training, whatever the budget: repeatable")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--preset", request->preset, "Of the views: paper, wide, needed or a YAML file")
      ->capture_default_str();
  sub->add_option("--view-set", request->view_overrides, "Override of the preset: group.key=value")
      ->take_all();
  sub->add_option("--set", request->overrides, "Override of the loop closer: group.key=value")
      ->take_all();
  sub->add_option("--json", *json_file, "File for the results, beside map.json in --out");
  sub->add_option("--threads", request->threads, "0: one per core");
  AddQuietOption(sub, &request->show_progress);
  sub->footer(
      "Run again after Ctrl-C, it goes on where it was.\n"
      "Example:\n  deja_view map --bag hall.bag --camera euroc.yaml --out hall_map\n"
      "  deja_view map --bag again.bag --camera euroc.yaml --add hall_map --out hall_map_2");
  sub->callback([=] {
    *command = [=] {
      try {
        const OutputLock lock = OutputLock::OfDirectory(request->out);
        const nlohmann::ordered_json json = RunMap(*request);
        WriteJson(*json_file, json);
        std::cout << json.dump(2) << "\n";
        for (const auto& advice : json["advice"]) {
          std::cerr << "advice: " << advice.get<std::string>() << "\n";
        }
        std::cerr << "see " << (request->out / "map.html").string() << "\n";
        return 0;
      } catch (const Interrupted&) {
        std::cerr << "deja_view: interrupted; the same command goes on from here\n";
        return 130;
      }
    };
  });
}

}  // namespace deja_view
