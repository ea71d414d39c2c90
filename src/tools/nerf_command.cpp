#include "nerf_command.hpp"

#include "deja_view/base/atomic_file.hpp"

#include <iostream>
#include <memory>

#include "commands.hpp"
#include "interrupt.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

void PrintJson(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    std::cout << fmt::format(
        "{:<18} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

void AddScaleOption(CLI::App* sub, double* scale) {
  sub->add_option("--scale", *scale, "Size of the images against the files'")
      ->check(CLI::Range(0.01, 1.0))
      ->capture_default_str();
}

void AddInputOptions(CLI::App* sub, NerfInput* input) {
  sub->add_option("--images", input->images, "Directory of images named <stamp in ns>.png or .jpg")
      ->required()
      ->check(CLI::ExistingDirectory);
  sub->add_option("--camera", input->camera, "Camera and extrinsics: VINS-Mono's YAML")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--poses", input->poses, "Trajectory in the TUM format")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--poses-of", input->poses_of, "What the trajectory is of")
      ->check(CLI::IsMember({"body", "camera"}))
      ->capture_default_str();
  sub->add_option("--holdout", input->holdout, "Hold out every N-th image; 0: none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  AddScaleOption(sub, &input->scale);
}

template <typename Run>
Command Reporting(std::shared_ptr<std::string> json_file, Run run) {
  return [json_file, run] {
    Json json;
    try {
      json = run();
    } catch (const Interrupted& e) {
      std::cerr << "deja_view: " << e.what() << "\n";
      return 130;
    }
    if (!json_file->empty()) {
      WriteFileAtomically(*json_file, [&](std::ostream& out) { out << json.dump(2) << "\n"; });
    }
    PrintJson(json);
    return json.value("interrupted", false) ? 130 : 0;
  };
}

template <typename Request>
void AddCommonOptions(CLI::App* sub, Request* request, std::string* json_file) {
  sub->add_option("--threads", request->threads, "Threads; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--json", *json_file, "File for the figures");
  sub->add_flag_callback(
      "--quiet", [request] { request->show_progress = false; }, "No progress");
}

void AddTrain(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("train", "Train a radiance field on posed images");
  auto request = std::make_shared<NerfTrainRequest>();
  auto json_file = std::make_shared<std::string>();
  AddInputOptions(sub, &request->input);
  AddCommonOptions(sub, request.get(), json_file.get());
  sub->add_option("--config", request->config, "YAML with training options")
      ->check(CLI::ExistingFile);
  sub->add_option("--set", request->overrides, "Override of an option: group.key=value")
      ->take_all();
  sub->add_option("--box", request->box, "The scene: min x y z, max x y z [m]")->expected(6);
  sub->add_option("--margin",
                  request->margin,
                  "Without --box: room about the cameras and points, times their box's diagonal; "
                  "default: 0.05, without points 0.6")
      ->check(CLI::Range(0.01, 100.0));
  sub->add_flag_callback(
      "--no-sparse-points",
      [request] { request->sparse_points = false; },
      "Don't look for points that images share");
  sub->add_flag("--color", request->input.color, "Train three channels");
  sub->add_option("--budget-s", request->budget_s, "Wall time [s]")
      ->check(CLI::Range(5.0, 1e7))
      ->capture_default_str();
  sub->add_option("--steps", request->steps, "Train this many steps, whatever the time; repeatable")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--checkpoint-s",
                  request->checkpoint_s,
                  "Write the model every so often on the way [s]; 0: only at the end and at Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--resume", request->resume, "Go on with a model whose training was cut short")
      ->check(CLI::ExistingFile);
  sub->add_option("--refined-poses",
                  request->refined_poses,
                  "File for the poses; they are corrected with --set refine_poses=true");
  sub->add_option("--out", request->out, "Model file")->required();
  sub->callback(
      [=] { *command = Reporting(json_file, [request] { return RunNerfTrain(*request); }); });
}

void AddEval(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("eval", "Compare renders with held-out images");
  auto request = std::make_shared<NerfEvalRequest>();
  auto json_file = std::make_shared<std::string>();
  AddInputOptions(sub, &request->input);
  AddCommonOptions(sub, request.get(), json_file.get());
  sub->add_option("--model", request->model, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--pictures", request->pictures, "Directory for real | rendered | difference");
  sub->add_option("--views", request->views, "At most this many views; 0: all")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--kernels", request->kernels, "Instructions: auto, portable, avx2, avx512")
      ->capture_default_str();
  sub->callback(
      [=] { *command = Reporting(json_file, [request] { return RunNerfEval(*request); }); });
}

void AddRender(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("render", "Render pictures along a trajectory");
  auto request = std::make_shared<NerfRenderRequest>();
  auto json_file = std::make_shared<std::string>();
  AddScaleOption(sub, &request->scale);
  AddCommonOptions(sub, request.get(), json_file.get());
  sub->add_option("--model", request->model, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--camera", request->camera, "Camera and extrinsics: VINS-Mono's YAML")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--trajectory", request->trajectory, "Poses in the TUM format")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--poses-of", request->poses_of, "What the trajectory is of")
      ->check(CLI::IsMember({"body", "camera"}))
      ->capture_default_str();
  sub->add_option("--fps", request->fps, "Pictures per second of the trajectory")
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
  sub->add_flag("--depth", request->depth, "Also write depth, 16 bit, millimetres along the ray");
  sub->add_option("--out", request->out, "Directory for the pictures")->required();
  sub->callback(
      [=] { *command = Reporting(json_file, [request] { return RunNerfRender(*request); }); });
}

void AddInfo(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("info", "Check a model file and show what it holds");
  auto path = std::make_shared<fs::path>();
  auto json_file = std::make_shared<std::string>();
  sub->add_option("model", *path, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--json", *json_file, "File for the figures");
  sub->callback([=] { *command = Reporting(json_file, [path] { return RunNerfInfo(*path); }); });
}

}  // namespace

void AddNerfCommand(CLI::App& app, Command* command) {
  CLI::App* nerf = app.add_subcommand("nerf", "Radiance fields: train, render, eval, info");
  nerf->require_subcommand(1);
  AddTrain(nerf, command);
  AddEval(nerf, command);
  AddRender(nerf, command);
  AddInfo(nerf, command);
}

}  // namespace deja_view
