#include "deja_view/base/atomic_file.hpp"

#include <iostream>
#include <memory>
#include <string>

#include "check/check_bag.hpp"
#include "common/commands.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

void Print(const Json& json) {
  for (const Json& topic : json["topics"]) {
    std::cout << fmt::format("{:<44} {:<36} {:>7}",
                             topic["name"].get<std::string>(),
                             topic["type"].get<std::string>(),
                             topic["messages"].get<std::int64_t>());
    if (topic.contains("rate_hz")) {
      std::cout << fmt::format("  {:>6.1f} Hz, gaps up to {:.2f} s",
                               topic["rate_hz"].get<double>(),
                               topic["longest_gap_s"].get<double>());
    }
    std::cout << (topic.contains("size") ? ", " + topic["size"].get<std::string>() : "") << "\n";
  }
  for (const Json& host : json["hosts"]) {
    std::cout << fmt::format(
        "\nas {}:\n  {}\n", host["host"].get<std::string>(), host["command"].get<std::string>());
  }
  std::cout << (json["problems"].empty() ? "\nnothing is wrong\n" : "\nproblems:\n");
  for (const Json& problem : json["problems"]) {
    std::cout << "  - " << problem.get<std::string>() << "\n";
  }
}

}  // namespace

void AddCheckCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<CheckRequest>();
  auto json_file = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "check", "Say what is in a bag, what it is good for, and what is wrong with it");
  sub->add_option("--bag", request->bag, "Bag with images, and poses or a VIO's keyframes")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--camera",
                  request->camera,
                  "The odometry's camera file: sizes, calibration and level are checked, too")
      ->check(CLI::ExistingFile);
  sub->add_option("--json", *json_file, "File for the results");
  sub->footer(
      "The exit code is 0 when nothing is wrong, 3 when something is.\n"
      "Example:\n  deja_view check --bag hall.bag --camera euroc.yaml");
  sub->callback([=] {
    *command = [=] {
      constexpr int kProblems = 3;
      const Json json = CheckBag(*request);
      Print(json);
      if (!json_file->empty()) {
        WriteFileAtomically(*json_file, [&](std::ostream& out) { out << json.dump(2) << "\n"; });
      }
      return json["problems"].empty() ? 0 : kProblems;
    };
  });
}

}  // namespace deja_view
