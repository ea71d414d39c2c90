#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/lab/evaluation/ape.hpp"

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "common/commands.hpp"
#include "common/reporting.hpp"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace deja_view {
namespace {

struct ApeRequest {
  std::filesystem::path truth;
  std::filesystem::path estimate;
  std::string alignment = "se3";
  double max_difference_s = 0.01;
  std::filesystem::path json;
};

int RunApe(const ApeRequest& request) {
  const Trajectory truth = ReadTum(request.truth);
  const Trajectory estimate = ReadTum(request.estimate);
  const auto pairs = PairByStamp(
      truth.stamps_ns, estimate.stamps_ns, std::llround(1e9 * request.max_difference_s));
  const auto alignment = EnumFromString<ApeAlignment>(request.alignment).value();
  const std::size_t needed = alignment == ApeAlignment::kNone ? 1 : 3;
  if (pairs.size() < needed) {
    ThrowInputError("{}: {} of its {} poses have one in {} within {} s; expected at least {}",
                    request.estimate.string(),
                    pairs.size(),
                    estimate.size(),
                    request.truth.string(),
                    request.max_difference_s,
                    needed);
  }
  std::vector<Eigen::Vector3d> true_positions;
  std::vector<Eigen::Vector3d> positions;
  for (const auto& [i, k] : pairs) {
    true_positions.push_back(truth.poses[i].t);
    positions.push_back(estimate.poses[k].t);
  }
  const ApeStatistics ape = ComputeApe(true_positions, positions, alignment);
  const nlohmann::ordered_json json = {{"poses", pairs.size()},
                                       {"alignment", request.alignment},
                                       {"max", ape.max},
                                       {"mean", ape.mean},
                                       {"median", ape.median},
                                       {"min", ape.min},
                                       {"rmse", ape.rmse}};
  for (const char* key : {"max", "mean", "median", "min", "rmse"}) {
    std::cout << fmt::format("{:>6}  {:.9f}\n", key, json[key].get<double>());
  }
  std::cout << fmt::format("{} poses, aligned: {}\n", pairs.size(), request.alignment);
  WriteJson(request.json, json);
  return 0;
}

}  // namespace

void AddApeCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<ApeRequest>();
  CLI::App* sub = app.add_subcommand("ape", "Absolute position error of a trajectory, as evo's");
  sub->add_option("truth", request->truth, "True poses (TUM)")->required();
  sub->add_option("estimate", request->estimate, "Estimated poses (TUM)")->required();
  sub->add_option("--align",
                  request->alignment,
                  "se3, as evo_ape -a; yaw: yaw and position alone; none, as evo_ape without -a")
      ->check(CLI::IsMember({"se3", "yaw", "none"}))
      ->capture_default_str();
  sub->add_option("--max-difference",
                  request->max_difference_s,
                  "Of the stamps of poses that are compared [s]")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--json", request->json, "File for the figures");
  sub->callback([=] { *command = [=] { return RunApe(*request); }; });
}

}  // namespace deja_view
