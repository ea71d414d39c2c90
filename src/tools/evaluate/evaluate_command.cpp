#include "deja_view/base/check.hpp"
#include "deja_view/base/output_lock.hpp"

#include <iostream>
#include <memory>

#include "common/commands.hpp"
#include "common/reporting.hpp"
#include "evaluate/evaluate.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

std::string Cell(const Json& entry, const char* key, const char* format) {
  const auto found = entry.find(key);
  return found == entry.end() || !found->is_number()
             ? "-"
             : fmt::format(fmt::runtime(format), found->get<double>());
}

void PrintTable(const Json& json) {
  struct Column {
    const char* title;
    const char* key;
    const char* format;
  };
  constexpr Column kColumns[] = {{"loops", "loops_accepted", "{:.0f}"},
                                 {"virtual", "loops_virtual", "{:.0f}"},
                                 {"precision", "precision", "{:.4f}"},
                                 {"recall", "recall", "{:.3f}"},
                                 {"R@P1", "recall_at_precision_1", "{:.3f}"},
                                 {"words", "detection_recall_at_precision_1", "{:.3f}"},
                                 {"r", "detection_r", "{:.3f}"},
                                 {"map", "map_recall", "{:.3f}"},
                                 {"mean", "ape_mean_m", "{:.4f}"},
                                 {"rmse", "ape_rmse_m", "{:.4f}"},
                                 {"cpu_s", "cpu_s", "{:.2f}"},
                                 {"+cpu_%", "added_cpu_percent", "{:+.1f}"},
                                 {"+MB", "added_rss_mb", "{:+.1f}"}};
  std::cout << fmt::format("{:<26}", "");
  for (const Column& column : kColumns) {
    std::cout << fmt::format(" {:>9}", column.title);
  }
  std::cout << "\n";
  for (const Json& entry : json.at("variants")) {
    std::cout << fmt::format("{:<26}", entry.at("name").get<std::string>());
    for (const Column& column : kColumns) {
      std::cout << fmt::format(" {:>9}", Cell(entry, column.key, column.format));
    }
    std::cout << "\n";
  }
}

/// "NAME=VALUE".
std::pair<std::string, std::string> SplitName(const std::string& option, const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == 0 || sign == std::string::npos ||
      text.find('/') < sign) {  // the name becomes a directory's
    ThrowInputError("{} {}: expected NAME=VALUE", option, text);
  }
  return {text.substr(0, sign), text.substr(sign + 1)};
}

}  // namespace

void AddEvaluateCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<EvaluateRequest>();
  auto json_file = std::make_shared<std::string>();
  auto virtual_bags = std::make_shared<std::vector<std::string>>();
  auto extra = std::make_shared<std::vector<std::string>>();
  CLI::App* sub = app.add_subcommand(
      "evaluate", "Replay a bag in many variants, each in a process of its own, side by side");
  sub->add_option("--bag", request->bag, "Bag with images and VINS-Mono's keyframes")->required();
  sub->add_option("--camera", request->camera, "Camera YAML of an odometry")->required();
  sub->add_option("--groundtruth", request->groundtruth, "True body poses (TUM)")->required();
  sub->add_option("--out", request->out, "Directory: a run per variant")->required();
  sub->add_option("--config", request->config, "Loop closer's YAML; defaults without");
  sub->add_option("--vocabulary", request->vocabulary, "Vocabulary; the shipped one without");
  sub->add_option("--load-map", request->load_map, "Map to start from");
  sub->add_option("--map-groundtruth", request->map_groundtruth, "True body poses of that map");
  sub->add_option("--revisit", request->revisit, "Metres and degrees of a revisit of the map")
      ->expected(2);
  sub->add_flag("--localise", request->localise, "Only look for the loaded map's places");
  sub->add_option("--virtual-bag", *virtual_bags, "NAME=BAG of virtual views; can be repeated")
      ->take_all();
  sub->add_option("--map-spacing", request->spacings_m, "Metres between places, a sweep");
  sub->add_option("--variant", *extra, "NAME=further arguments of replay; can be repeated")
      ->take_all();
  sub->add_option("--only", request->only, "Names of the variants to run");
  sub->add_option("--json", *json_file, "File for the results; OUT/evaluation.json without");
  AddQuietOption(sub, &request->show_progress);
  sub->footer(
      "Example:\n  deja_view evaluate --bag hall.bag --camera euroc.yaml --groundtruth truth.txt "
      "--map-spacing 0.5 2 4 10 --out evaluation");
  sub->callback([=] {
    *command = [=] {
      for (const std::string& text : *virtual_bags) {
        request->virtual_bags.emplace_back(SplitName("--virtual-bag", text));
      }
      for (const std::string& text : *extra) {
        request->extra.push_back(SplitName("--variant", text));
      }
      const OutputLock lock = OutputLock::OfDirectory(request->out);
      const std::filesystem::path file =
          json_file->empty() ? request->out / "evaluation.json" : std::filesystem::path(*json_file);
      return Report([&] { return RunEvaluate(*request); }, file.string(), PrintTable);
    };
  });
}

}  // namespace deja_view
