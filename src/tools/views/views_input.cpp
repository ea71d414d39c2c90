#include "views/views_input.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/field_renderer.hpp"

#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <utility>

#include "common/pose_input.hpp"
#include "common/shared_files.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

fs::path FindPreset(const std::string& preset) {
  return preset == "paper" || preset == "wide" ? FindSharedFile("views_" + preset + ".yaml")
                                               : fs::path(preset);
}

// Where a network may lie that is named by a relative path.
std::vector<fs::path> NetworkDirectories(const fs::path& preset) {
  return {preset.parent_path(), FindSharedFile("views_paper.yaml").parent_path()};
}

Trajectory OfCamera(PoseSource source, const Rigid3& T_B_C) {
  return source.is_of_camera ? std::move(source.trajectory) : Transform(source.trajectory, T_B_C);
}

const std::string& ImageTopic(const FlightFiles& files, const VinsConfig& config) {
  return files.image_topic.empty() ? config.image_topic : files.image_topic;
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

std::string DescribeCells(const std::vector<nerf::SceneCell>& cells) {
  std::string text;
  for (const nerf::SceneCell& cell : cells) {
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
  return OpenImageFlight(files.images, ImageTopic(files, config), config.camera);
}

PosedJob ReadViewsInput(const ViewsInput& input) {
  PosedJob posed;
  ViewJob& job = posed.job;
  const VinsConfig config = ReadVinsConfig(input.flight.camera);
  job.flight = OpenFlight(input.flight);
  job.camera = config.camera;
  job.T_B_C = config.T_B_C;
  job.topics.image = ImageTopic(input.flight, config);
  // Those of a bag are in it already.
  job.pose_topic = input.flight.bag.empty() ? "/odometry" : "";
  job.sources = EnumFromString<SourceKind>(input.sources).value();
  const fs::path preset = FindPreset(input.preset);
  ReadOptions(preset, &job.options);
  for (const std::string& assignment : input.overrides) {
    OverrideOption(assignment, &job.options);
  }
  std::filesystem::path& network = job.options.rendering.network;
  network = FindNetwork(network, NetworkDirectories(preset));
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

ViewModel ReadModel(const fs::path& path, const PosedJob& posed) {
  const auto renderer = std::make_shared<nerf::FieldRenderer>(
      std::make_shared<nerf::RadianceField>(nerf::ReadField(path)));
  ViewModel model;
  const Similarity3 W_N =
      posed.tell_model_frame ? posed.poses.W_N : nerf::RequireFrame(renderer->field().frame, path);
  model.renderer = PlaceInWorld(renderer, W_N);
  model.settings = fmt::format("model: {} {:016x}\n", path.filename().string(), HashFile(path));
  const nerf::SceneCells& cells = renderer->field().cells;
  if (cells.IsCut()) {
    model.sub_map.settings = model.settings.substr(0, model.settings.size() - 1);
    model.settings = fmt::format(
        "sub-maps: {} {:016x}\n", cells.cells.size(), Hash64(DescribeCells(cells.cells)));
    model.sub_map.shard = cells.shard();
    model.sub_map.is_own = [cells, N_W = W_N.Inverse()](const Eigen::Vector3d& p_W) {
      return cells.IsOwn(N_W * p_W);
    };
  }
  return model;
}

std::uint64_t HashFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    ThrowInputError("{}: can't be read", path.string());
  }
  return Hash64({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
}

ViewRendererFactory WarpFactory(std::shared_ptr<const Camera> camera,
                                std::shared_ptr<const DepthMaps> maps) {
  return [camera, maps](const ViewSource& source, const std::vector<RangeSample>& points) {
    // A depth image has edges; between tracked points there are none to be found.
    constexpr int kFineMesh_px = 1;
    constexpr int kCoarseMesh_px = 4;
    return maps && maps->Has(source.stamp_ns)
               ? std::make_shared<DepthWarpRenderer>(
                     source.image, maps->Read(source.stamp_ns), camera, source.T_N_C, kFineMesh_px)
               : std::make_shared<DepthWarpRenderer>(source.image,
                                                     DensifyRanges(points, source.image.size()),
                                                     camera,
                                                     source.T_N_C,
                                                     kCoarseMesh_px);
  };
}

}  // namespace deja_view
