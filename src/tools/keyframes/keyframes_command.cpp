#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/fusion/loop_fusion_options.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/ros/bag/keyframe_bag.hpp"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "common/commands.hpp"
#include "common/problem_lines.hpp"
#include "common/reporting.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

struct KeyframesRequest {
  std::string bag;
  std::string camera;
  std::string image_topic;  // empty: the camera file's
  std::string odometry_topic = "/odometry";
  std::string second_camera;       // empty: none
  std::string second_image_topic;  // empty: its camera file's
  std::string out;
  std::string config;
  std::vector<std::string> overrides;
  bool show_progress = true;
};

std::string ImageTopic(const std::string& given,
                       const VinsConfig& vins,
                       const std::string& camera) {
  return given.empty() ? RequireImageTopic(vins, camera) : given;
}

KeyframeBagJob MakeJob(const KeyframesRequest& request) {
  LoopFusionOptions options;
  ReadOptions(request.config, request.overrides, &options);
  const VinsConfig vins = ReadVinsConfig(request.camera);
  KeyframeBagJob job;
  job.bag = request.bag;
  job.out = request.out;
  job.image_topic = ImageTopic(request.image_topic, vins, request.camera);
  job.odometry_topic = request.odometry_topic;
  job.front_end = {options.front_end, vins.camera, vins.T_B_C, GravityPolicy::kGiven, {}};
  if (!request.second_camera.empty()) {
    const VinsConfig second = ReadVinsConfig(request.second_camera);
    job.second_image_topic = ImageTopic(request.second_image_topic, second, request.second_camera);
    if (job.second_image_topic == job.image_topic) {
      ThrowInputError("{}: image topic {}: expected another one than {}'s",
                      request.second_camera,
                      job.second_image_topic,
                      request.camera);
    }
    job.front_end.second = SecondCamera{second.camera, second.T_B_C};
  }
  return job;
}

Json ToJson(const FrontEndCounts& counts) {
  return {{"images", counts.images},
          {"images_without_pose", counts.without_pose},
          {"keyframes", counts.keyframes},
          {"keyframes_without_points", counts.without_points},
          {"points", counts.points}};
}

Json MakeKeyframes(const KeyframesRequest& request) {
  KeyframeBagJob job = MakeJob(request);
  Progress progress("keyframes", "messages", 0);
  std::vector<std::string> problems;
  job.on_problem = [&problems](const std::string& what) { problems.push_back(what); };
  if (request.show_progress) {
    job.on_progress = [&progress](std::int64_t done, std::int64_t total) {
      progress.SetTotal(static_cast<std::size_t>(total));
      progress.Update(static_cast<std::size_t>(done));
    };
  }
  const FrontEndCounts counts = WriteKeyframeBag(job);
  if (request.show_progress) {
    progress.Finish(static_cast<std::size_t>(counts.images + counts.poses));
  }
  for (const std::string& line : ProblemLines(problems)) {
    std::cerr << "warning: " << line << "\n";
  }
  if (counts.without_points > 0) {
    std::cerr << fmt::format(
        "warning: {} of {} keyframes have no points: their images are too far apart, or too little "
        "parallax lies between them\n",
        counts.without_points,
        counts.keyframes);
  }
  return ToJson(counts);
}

}  // namespace

void AddKeyframesCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<KeyframesRequest>();
  CLI::App* sub = app.add_subcommand(
      "keyframes",
      "Make keyframes of a bag's images and poses, and write them in VINS-Mono's topics");
  sub->add_option("--bag", request->bag, "Bag with images and poses")->required();
  sub->add_option("--camera", request->camera, "Camera YAML of an odometry")->required();
  sub->add_option(
      "--image-topic", request->image_topic, "Of the images; the camera file's without");
  sub->add_option("--odometry-topic",
                  request->odometry_topic,
                  "Body poses (Odometry, PoseStamped, PoseWithCovarianceStamped, "
                  "TransformStamped), or tf:WORLD,BODY; /odometry without");
  sub->add_option("--second-camera",
                  request->second_camera,
                  "Camera YAML of a second camera that films at the same stamps: its images give "
                  "points, too, so that those far apart in time have some");
  sub->add_option(
      "--second-image-topic", request->second_image_topic, "Its topic; its camera file's without");
  sub->add_option("--out", request->out, "Bag to write")->required();
  sub->add_option("--config", request->config, "Loop closer's YAML; defaults without");
  sub->add_option("--set", request->overrides, "Override of the config: front_end.key=value")
      ->take_all();
  AddQuietOption(sub, &request->show_progress);
  sub->footer(
      "Example:\n  deja_view keyframes --bag rig.bag --camera left.yaml --second-camera right.yaml "
      "\\\n    --odometry-topic /vicon/pose --out flight.bag\n"
      "  deja_view replay --bag flight.bag --camera left.yaml");
  ReportOf(sub, command, MakeKeyframes, request);
}

}  // namespace deja_view
