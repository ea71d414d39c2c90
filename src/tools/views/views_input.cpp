#include "views/views_input.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"

#include <iostream>
#include <optional>
#include <utility>

#include "common/pose_input.hpp"
#include "common/shared_files.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

fs::path FindPreset(const std::string& preset) {
  if (preset == "paper" || preset == "wide" || preset == "needed") {
    return FindSharedFile("views_" + preset + ".yaml");
  }
  if (!fs::exists(preset)) {
    ThrowInputError("--preset {}: expected paper, wide, needed, or a YAML file", Quote(preset));
  }
  return preset;
}

// Where a network may lie that is named by a relative path.
std::vector<fs::path> NetworkDirectories(const fs::path& preset) {
  return {preset.parent_path(), FindSharedFile("views_paper.yaml").parent_path()};
}

Trajectory OfCamera(PoseSource source, const Rigid3& T_B_C) {
  return source.is_of_camera ? std::move(source.trajectory) : Transform(source.trajectory, T_B_C);
}

// The VIO's poses of the camera, where there are any.
std::optional<Trajectory> ReadReference(const ViewsInput& input, const ViewJob& job) {
  const std::string& topic = job.topics.keyframe_pose;
  if (input.align_to == "off" || (input.align_to == "auto" && !job.flight->HasTopic(topic))) {
    return std::nullopt;
  }
  const std::string& poses = input.align_to == "auto" ? topic : input.align_to;
  return OfCamera(ReadFlightPoses(poses, input.flight.bag, false), job.T_B_C);
}

// Reads the poses of the camera into the job, in metres.
void ReadPoses(const ViewsInput& input, PosedJob* posed) {
  ViewJob* job = &posed->job;
  PoseSource source = ReadFlightPoses(input.poses, input.flight.bag, input.poses_of == "camera");
  // What is not to be aligned is taken to be in metres.
  const bool has_scale = source.has_scale || input.align_to == "off";
  posed->tell_model_frame = !source.has_scale;
  const Trajectory T_N_C = OfCamera(std::move(source), job->T_B_C);
  PoseFrame& frame = posed->poses;
  frame = FindPoseFrame(T_N_C,
                        has_scale,
                        ReadReference(input, *job),
                        job->options.poses,
                        fmt::format("{}, against the VIO (--align-to)", input.poses));
  job->T_N_C = has_scale ? T_N_C : Transform(frame.W_N, T_N_C);
  if (input.show_progress) {
    std::cerr << fmt::format(
        "poses: {}\n",
        frame.fit ? frame.fit->Summary() : "not compared with a VIO: " + frame.not_checked);
  }
}

std::string DescribeCells(const std::vector<SceneCell>& cells) {
  std::string text;
  for (const SceneCell& cell : cells) {
    for (const Eigen::Vector3d& corner : {cell.min, cell.max}) {
      text += fmt::format("{} {} {}\n", corner.x(), corner.y(), corner.z());
    }
  }
  return text;
}

}  // namespace

std::shared_ptr<const ViewFlight> OpenFlight(const FlightFiles& files) {
  if (files.bag.empty() == files.images.empty()) {
    ThrowInputError("expected either --bag or --images, found {}",
                    files.bag.empty() ? "none" : "both");
  }
  if (files.images.empty()) {
    return OpenBagFlight(files.bag);
  }
  if (files.camera.empty()) {
    ThrowInputError("--images needs --camera");
  }
  const VinsConfig config = ReadVinsConfig(files.camera);
  return OpenImageFlight(
      files.images, RequireImageTopic(config, files.camera, files.image_topic), config.camera);
}

PosedJob ReadViewsInput(const ViewsInput& input) {
  PosedJob posed;
  ViewJob& job = posed.job;
  const VinsConfig config = ReadVinsConfig(input.flight.camera);
  job.flight = OpenFlight(input.flight);
  job.camera = config.camera;
  job.T_B_C = config.T_B_C;
  job.topics.image = RequireImageTopic(config, input.flight.camera, input.flight.image_topic);
  // Those of a bag are in it already.
  job.pose_topic = input.flight.bag.empty() ? "/odometry" : "";
  job.sources = EnumFromString<SourceKind>(input.sources).value();
  const fs::path preset = FindPreset(input.preset);
  ReadOptions(preset, input.overrides, &job.options);
  std::filesystem::path& network = job.options.rendering.network;
  network = FindNetwork(network, NetworkDirectories(preset));
  if (job.options.rendering.method == Upscaling::kFsrcnn && !fs::is_regular_file(network)) {
    ThrowInputError(
        "{}: rendering.network: no file {}: expected one here, beside the preset, or in {}",
        preset.string(),
        Quote(network.string()),
        FindSharedFile("views_paper.yaml").parent_path().string());
  }
  ReadPoses(input, &posed);
  if (!input.places.empty()) {
    job.source_stamps_ns = ReadTum(input.places).stamps_ns;
  }
  job.threads = input.threads;
  return posed;
}

nlohmann::ordered_json ToJson(const PoseFrame& frame) {
  return frame.fit ? ToJson(*frame.fit)
                   : nlohmann::ordered_json{{"not_checked", frame.not_checked}};
}

ViewModel PlaceModel(const std::shared_ptr<const SceneModel>& model, const PosedJob& posed) {
  const Similarity3 W_N =
      model->FindFrame(posed.tell_model_frame ? std::optional(posed.poses.W_N) : std::nullopt);
  ViewModel placed;
  placed.renderers = RenderersInWorld(model, W_N);
  placed.settings = model->Describe();
  if (const SceneCells cells = model->cells(); cells.IsCut()) {
    placed.sub_map.settings = placed.settings.substr(0, placed.settings.size() - 1);
    placed.settings = fmt::format(
        "sub-maps: {} {:016x}\n", cells.cells.size(), Hash64(DescribeCells(cells.cells)));
    placed.sub_map.shard = cells.shard();
    placed.sub_map.is_own = [cells, N_W = W_N.Inverse()](const Eigen::Vector3d& p_W) {
      return cells.IsOwn(N_W * p_W);
    };
  }
  return placed;
}

std::shared_ptr<const DepthMaps> OpenFlightMaps(const DepthMapFiles& files, const ViewJob& job) {
  auto maps = OpenDepthMaps(files, job.camera);
  if (maps != nullptr) {
    CountDepthMaps(*maps, job);
  }
  return maps;
}

std::size_t CountDepthMaps(const DepthMaps& maps, const ViewJob& job) {
  std::vector<std::int64_t> stamps_ns;
  for (const RecordedImage& image : job.flight->ListImages(job.topics.image)) {
    stamps_ns.push_back(image.stamp_ns);
  }
  return maps.CountImages(stamps_ns, job.flight->path());
}

}  // namespace deja_view
