#include "nerf/nerf_command.hpp"

#include <iostream>
#include <memory>

#include "common/commands.hpp"
#include "common/device_option.hpp"
#include "common/reporting.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

void AddScaleOption(CLI::App* sub, double* scale) {
  sub->add_option("--scale", *scale, "Size of the images against the files'")
      ->check(CLI::Range(0.01, 1.0))
      ->capture_default_str();
}

void AddSourceOptions(CLI::App* sub, NerfInput* input) {
  sub->add_option("--images",
                  input->images,
                  "Directory of images named by their stamps (ns, or s with a point), EuRoC's ASL "
                  "folder, or the images of --colmap")
      ->check(CLI::ExistingDirectory);
  sub->add_option("--camera", input->camera, "Camera and extrinsics: an odometry's YAML")
      ->check(CLI::ExistingFile);
  sub->add_option("--poses",
                  input->poses,
                  "Trajectory: TUM, EuRoC's or VINS-Mono's CSV, a COLMAP model, or a bag with "
                  "--pose-topic")
      ->check(CLI::ExistingPath);
  AddPosesOfOption(sub, &input->poses_of, "What the trajectory is of");
  sub->add_option("--transforms", input->transforms, "instant-ngp's or nerfstudio's JSON")
      ->check(CLI::ExistingFile);
  sub->add_option("--colmap", input->colmap, "COLMAP model, text or binary")
      ->check(CLI::ExistingDirectory);
  sub->add_option("--seven-scenes",
                  input->seven_scenes,
                  "Directory of frame-*.{color,pose,depth} and camera-intrinsics.txt")
      ->check(CLI::ExistingDirectory);
#ifdef DEJA_VIEW_WITH_ROS
  sub->add_option("--bag", input->bag, "Bag with images")->check(CLI::ExistingFile);
  sub->add_option("--image-topic", input->image_topic, "Its images; default: as --camera says");
  sub->add_option(
      "--pose-topic",
      input->pose_topic,
      "Odometry, PoseStamped, PoseWithCovarianceStamped or TransformStamped in --poses or --bag");
  sub->add_option("--points",
                  input->points,
                  "Bag with VINS-Mono's keyframes, whose points become depth points")
      ->check(CLI::ExistingFile);
#endif
}

void AddImageOptions(CLI::App* sub, NerfInput* input) {
  sub->add_option("--every", input->every, "Take every N-th image")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--holdout",
                  input->holdout,
                  "Hold out every N-th image, and those with a depth map where at most half of the "
                  "images have one; 0: none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  AddScaleOption(sub, &input->scale);
  sub->add_option("--max-side", input->max_side, "Shrink images to this longest side [px]")
      ->check(CLI::PositiveNumber);
}

void AddTrainOptions(CLI::App* sub, fs::path* config, std::vector<std::string>* overrides) {
  sub->add_option("--config", *config, "YAML with training options")->check(CLI::ExistingFile);
  sub->add_option("--set", *overrides, "Override of an option: group.key=value")->take_all();
}

template <typename Request>
void AddCommonOptions(CLI::App* sub, Request* request) {
  sub->add_option("--threads", request->threads, "Threads; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  AddQuietOption(sub, &request->show_progress);
}

void AddTrain(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("train", "Train a radiance field on posed images");
  auto request = std::make_shared<NerfTrainRequest>();
  AddNerfInputOptions(sub, &request->input);
  AddCommonOptions(sub, request.get());
  AddTrainOptions(sub, &request->config, &request->overrides);
  AddDeviceOption(sub, &request->device);
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
  sub->add_flag("--grey", request->input.grey, "Train one channel, even on colour images");
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
  sub->add_option("--start-from",
                  request->start_from,
                  "A trained model to learn more from: of the same place and frame, given images "
                  "that it was trained on and new ones")
      ->check(CLI::ExistingFile);
  sub->add_option("--shard",
                  request->shard,
                  "Cut the scene into n sub-maps by where the cameras are, and train the field of "
                  "sub-map i: i/n");
  sub->add_option("--out", request->out, "Model file")->required();
  sub->footer(
      "Example, the second half of a large place:\n  deja_view nerf train --images images --camera "
      "euroc.yaml --poses truth.txt --shard 1/2 --out hall-1.dvn");
  ReportOf(sub, command, RunNerfTrain, request);
}

void AddEval(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("eval", "Compare renders with held-out images");
  auto request = std::make_shared<NerfEvalRequest>();
  AddNerfInputOptions(sub, &request->input);
  AddCommonOptions(sub, request.get());
  AddDeviceOption(sub, &request->device);
  sub->add_option("--model", request->model, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--pictures", request->pictures, "Directory for real | rendered | difference");
  sub->add_option("--views", request->views, "At most this many views; 0: all")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--shard",
                  request->shard,
                  "Only held-out images of sub-map i of n: i/n; a sub-map's model: of its own");
  sub->add_option("--kernels", request->kernels, "Instructions: auto, portable, avx2, avx512")
      ->capture_default_str();
  ReportOf(sub, command, RunNerfEval, request);
}

std::string Cell(const Json& value, int digits) {
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : "-";
}

void PrintComparison(const Json& json) {
  std::cout << fmt::format("{} images, {} steps each\n{:<16} {:>9} {:>7} {:>8} {:>13}\n",
                           json["images"].dump(),
                           json["steps"].dump(),
                           "poses",
                           "PSNR [dB]",
                           "SSIM",
                           "corners",
                           "residual [m]");
  for (const Json& source : json["sources"]) {
    const Json& alignment = source["alignment"];
    std::cout << fmt::format("{:<16} {:>9} {:>7} {:>8} {:>13}\n",
                             source["name"].get<std::string>(),
                             Cell(source["psnr_db"], 2),
                             Cell(source["ssim"], 4),
                             Cell(source["corner_match_rate"], 3),
                             alignment.is_null() ? "-" : Cell(alignment["rmse_m"], 3));
  }
}

void AddComparePoses(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand(
      "compare-poses", "Train a short field per source of poses and compare held-out views");
  auto request = std::make_shared<NerfCompareRequest>();
  sub->add_option("--source",
                  request->sources,
                  "NAME=FILE, poses of the body: TUM, EuRoC's or VINS-Mono's CSV, a COLMAP model "
                  "(of the camera), or BAG:/topic; repeatable");
  sub->add_option("--camera-source", request->camera_sources, "As --source, poses of the camera");
  sub->add_option("--reference",
                  request->reference,
                  "Poses, as those of --source, to which all are aligned; a bad fit is an error");
  sub->add_option("--images", request->input.images, "Directory of images named by their stamps")
      ->required()
      ->check(CLI::ExistingDirectory);
  sub->add_option("--camera", request->input.camera, "Camera and extrinsics: an odometry's YAML")
      ->required()
      ->check(CLI::ExistingFile);
  AddImageOptions(sub, &request->input);
  sub->add_flag("--grey", request->input.grey, "Train one channel, even on colour images");
  AddTrainOptions(sub, &request->config, &request->overrides);
  AddCommonOptions(sub, request.get());
  sub->add_option("--steps", request->steps, "Steps of each training")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--pictures", request->pictures, "Directory for real | rendered | difference");
  ReportOf(sub, command, RunNerfComparePoses, request, PrintComparison);
}

void AddRender(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("render", "Render pictures along a trajectory");
  auto request = std::make_shared<NerfRenderRequest>();
  AddScaleOption(sub, &request->scale);
  AddCommonOptions(sub, request.get());
  AddDeviceOption(sub, &request->device);
  sub->add_option("--model", request->model, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--camera", request->camera, "Camera and extrinsics: an odometry's YAML")
      ->check(CLI::ExistingFile);
  sub->add_option("--trajectory",
                  request->trajectory,
                  "Poses: TUM, EuRoC's or VINS-Mono's CSV, or a COLMAP model")
      ->check(CLI::ExistingPath);
  AddPosesOfOption(sub, &request->poses_of, "What the trajectory is of");
  sub->add_option("--transforms",
                  request->transforms,
                  "Instead of both, the frames of a transforms.json, one picture each")
      ->check(CLI::ExistingFile);
  sub->add_option("--fps", request->fps, "Pictures per second of the trajectory")
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
  sub->add_flag("--depth", request->depth, "Also write depth, 16 bit, millimetres along the ray");
  sub->add_option("--out", request->out, "Directory for the pictures")->required();
  ReportOf(sub, command, RunNerfRender, request);
}

void AddAlign(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand(
      "align", "Place a field that was trained on COLMAP's poses among poses in metres");
  auto request = std::make_shared<NerfAlignRequest>();
  sub->add_option("--model", request->model, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--poses",
                  request->poses,
                  "What it was trained on: a COLMAP model, TUM, EuRoC's or VINS-Mono's CSV, or "
                  "BAG:/topic")
      ->required();
  AddPosesOfOption(sub, &request->poses_of, "What these poses are of");
  sub->add_option("--align-to",
                  request->align_to,
                  "Poses of the body in metres, as --poses: those of the VIO, say")
      ->required();
  sub->add_option("--camera", request->camera, "Camera and extrinsics: an odometry's YAML")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--max-rmse-m", request->max_rmse_m, "A worse fit is an error [m]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--out", request->out, "Model file to write; may be --model")->required();
  sub->footer(
      "Example:\n  deja_view nerf align --model hall.dvn --poses hall_colmap --align-to "
      "hall.bag:/vins_estimator/keyframe_pose --camera euroc.yaml --out hall.dvn");
  ReportOf(sub, command, RunNerfAlign, request);
}

void AddInfo(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand(
      "info", "Show the graphics cards there are, and check a model file and show what it holds");
  auto path = std::make_shared<fs::path>();
  sub->add_option("model", *path, "Model file")->check(CLI::ExistingFile);
  ReportOf(sub, command, RunNerfInfo, path);
}

}  // namespace

void AddNerfInputOptions(CLI::App* sub, NerfInput* input) {
  AddSourceOptions(sub, input);
  sub->add_flag("--skip-missing",
                input->skip_missing,
                "Leave out images without a pose and poses without an image");
  AddImageOptions(sub, input);
}

void AddNerfCommand(CLI::App& app, Command* command) {
  CLI::App* nerf = app.add_subcommand(
      "nerf", "Radiance fields: train, eval, render, compare poses, align, info");
  nerf->require_subcommand(1);
  AddTrain(nerf, command);
  AddEval(nerf, command);
  AddComparePoses(nerf, command);
  AddRender(nerf, command);
  AddAlign(nerf, command);
  AddInfo(nerf, command);
}

}  // namespace deja_view
