#include "views/views_command.hpp"

#include "deja_view/scene/open_scene_model.hpp"

#include <iostream>
#include <memory>

#include "common/commands.hpp"
#include "common/device_option.hpp"
#include "common/reporting.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNothingLeft = "; the same command starts afresh";

void PrintValues(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    std::cout << fmt::format("{:<18} {}\n", key, value.dump());
  }
}

void PrintMatches(const Json& json) {
  std::cout
      << "per view          views  visible  matched  correct  precision  render [ms]  CPU [ms]  "
         "[kB]\n";
  for (const auto& [key, value] : json.items()) {
    if (value.contains("correct")) {
      std::cout << fmt::format(
          "{:<16} {:>6} {:>8.1f} {:>8.1f} {:>8.1f} {:>10.3f} {:>12.1f} "
          "{:>9.1f} {:>5.1f}\n",
          key,
          value["views"].get<int>(),
          value["visible"].get<double>(),
          value["matched"].get<double>(),
          value["correct"].get<double>(),
          value["precision"].get<double>(),
          value["render_ms_median"].get<double>(),
          value["render_cpu_ms"].get<double>(),
          1e-3 * value["bytes"].get<double>());
    }
  }
  std::cout << fmt::format(
      "{} images, {} not recognised; {} poses not in free space, {} uncertain\n",
      json["images"].get<int>(),
      json["not_recognised"].get<int>(),
      json["not_free"].get<int>(),
      json["uncertain"].get<int>());
}

void AddFlightOptions(CLI::App* sub, FlightFiles* flight) {
  CLI::Option* bag =
      sub->add_option("--bag", flight->bag, "Bag with images, and VINS-Mono's keyframes if any")
          ->check(CLI::ExistingFile);
  sub->add_option("--images",
                  flight->images,
                  "Instead, a folder of images named by their stamps (ns, or s with a point), or "
                  "EuRoC's ASL folder")
      ->check(CLI::ExistingDirectory)
      ->excludes(bag);
  sub->add_option("--camera", flight->camera, "Camera YAML of an odometry")
      ->check(CLI::ExistingFile);
  sub->add_option("--image-topic", flight->image_topic, "Images; the camera YAML's without");
}

void AddInputOptions(CLI::App* sub, ViewsInput* input) {
  AddFlightOptions(sub, &input->flight);
  sub->get_option("--camera")->required();
  sub->add_option(
         "--poses",
         input->poses,
         "Poses in the model's frame: TUM file, vins_result of VINS-Mono, EuRoC's data.csv or ASL "
         "folder, COLMAP model, BAG:/topic, or topic of the bag")
      ->required();
  AddPosesOfOption(sub, &input->poses_of, "What the poses are of");
  sub->add_option("--align-to",
                  input->align_to,
                  "Poses of the body that tell whether --poses fit, and give those of COLMAP their "
                  "scale: auto (the VIO's in the bag, if any), off, or as --poses")
      ->capture_default_str();
  sub->add_option("--model",
                  input->model,
                  "Radiance field, as `deja_view nerf train` writes it; a sub-map's: only its own "
                  "images get views, to be merged with the other sub-maps'")
      ->check(CLI::ExistingFile);
  sub->add_option("--preset",
                  input->preset,
                  "paper, wide, needed, or a YAML file like config/views_paper.yaml")
      ->capture_default_str();
  sub->add_option("--set", input->overrides, "Override of the preset: group.key=value")->take_all();
  sub->add_option("--sources", input->sources, "Images that may get views; auto: keyframes if any")
      ->check(CLI::IsMember({"auto", "keyframes", "images"}))
      ->capture_default_str();
  sub->add_option(
         "--places",
         input->places,
         "TUM file, as replay's places.txt: views of the images at its stamps, whatever the "
         "preset says of sources")
      ->check(CLI::ExistingFile);
  sub->add_option("--threads", input->threads, "Threads; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  AddQuietOption(sub, &input->show_progress);
}

void AddDepthMapOptions(CLI::App* sub, DepthMapFiles* maps) {
  CLI::Option* directory =
      sub->add_option(
             "--depth-maps",
             maps->directory,
             "16-bit depth images, by which images are warped: named by the images' stamps "
             "and seen by their camera, or a folder of 7-Scenes")
          ->check(CLI::ExistingDirectory);
  sub->add_option("--depth-along",
                  maps->along,
                  "What they measure along: the optical axis, or the pixel's ray (as simulate "
                  "--ranges)")
      ->check(CLI::IsMember({"axis", "ray"}))
      ->capture_default_str()
      ->needs(directory);
  sub->add_option("--depth-unit", maps->unit_m, "Their unit [m]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(directory);
}

void AddRender(CLI::App* views, Command* command) {
  CLI::App* sub =
      views->add_subcommand("render", "Add virtual views to a bag or a folder of images");
  auto request = std::make_shared<ViewsRenderRequest>();
  AddInputOptions(sub, &request->input);
  sub->add_option("--renderer",
                  request->renderer,
                  "nerf, or warp: the image itself by the VIO's points or --depth-maps")
      ->check(CLI::IsMember(SceneRenderers()))
      ->capture_default_str();
  AddDeviceOption(sub, &request->device);
  sub->add_option("--content", request->content, "What a view carries")
      ->check(CLI::IsMember({"image", "features", "both"}))
      ->capture_default_str();
  AddDepthMapOptions(sub, &request->input.depth_maps);
  sub->add_flag("--depth", request->depth, "Also depth and certainty per pixel");
  sub->add_flag("--plain-topics", request->plain_topics, "Also Image, CameraInfo and PoseStamped");
  sub->add_flag("--views-only",
                request->views_only,
                "Leave out the flight's own messages: replay --virtual-bag");
  sub->add_option("--shard", request->shard, "Render part i of n, to be merged: i/n")
      ->capture_default_str();
  sub->add_flag_callback(
      "--no-resume", [request] { request->resume = false; }, "Make finished views anew");
  sub->add_option("--out", request->out, "Bag to write")->required();
  sub->footer(
      "Unfinished work is kept in OUT.work; the same command goes on from there.\n"
      "Examples:\n"
      "  deja_view views render --bag hall.bag --camera euroc.yaml --poses truth.txt --model "
      "hall.dvn --preset wide --out hall_views.bag\n"
      "  deja_view views render --images MH_01_easy --camera euroc.yaml --poses MH_01_easy --model "
      "mh_01.dvn --out mh_01_views.bag\n"
      "  deja_view views render --images images --camera camera.yaml --poses truth.txt --renderer "
      "warp --depth-maps depth --out views.bag");
  ReportOf(
      sub, command, RunViewsRender, request, PrintValues, "; the same command goes on from here");
}

void AddMerge(CLI::App* views, Command* command) {
  CLI::App* sub = views->add_subcommand(
      "merge", "Put the parts of views render --shard, and those of sub-maps, together");
  auto request = std::make_shared<ViewsMergeRequest>();
  AddFlightOptions(sub, &request->flight);
  sub->add_option("parts", request->parts, "Bags of all shards and sub-maps, in any order")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_flag("--views-only", request->views_only, "Leave out the flight's own messages");
  sub->add_option("--out", request->out, "Bag to write")->required();
  sub->footer(
      "The flight is given as to views render.\n"
      "Examples:\n  deja_view views merge --bag hall.bag parts/*.bag --out hall_views.bag\n"
      "  deja_view views merge --images MH_01_easy --camera euroc.yaml parts/*.bag --out "
      "mh_01_views.bag");
  ReportOf(sub, command, RunViewsMerge, request, PrintValues, kNothingLeft);
}

void AddCheck(CLI::App* views, Command* command) {
  CLI::App* sub =
      views->add_subcommand("check", "Count correct matches between images and their views");
  auto request = std::make_shared<ViewsCheckRequest>();
  AddInputOptions(sub, &request->input);
  sub->get_option("--model")->required();
  AddDepthMapOptions(sub, &request->input.depth_maps);
  sub->add_option("--count", request->count, "Images to check, spread over the flight")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  sub->add_option("--ways", request->ways, "Only these ways of rendering; all without")
      ->check(CLI::IsMember({"direct", "bicubic", "patches", "fsrcnn"}));
  sub->add_option("--fsrcnn",
                  request->network,
                  "Network to upscale with, e.g. FSRCNN_x2.pb; the preset's without")
      ->check(CLI::ExistingFile);
  ReportOf(sub, command, RunViewsCheck, request, PrintMatches, kNothingLeft);
}

}  // namespace

void AddViewsCommand(CLI::App& app, Command* command) {
  CLI::App* views =
      app.add_subcommand("views", "Virtual views: render them into a bag, merge parts, check");
  views->require_subcommand(1);
  AddRender(views, command);
  AddMerge(views, command);
  AddCheck(views, command);
}

}  // namespace deja_view
