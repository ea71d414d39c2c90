#include "views_input.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/checkpoint.hpp"

#include <fstream>
#include <iterator>

#include "shared_files.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

fs::path FindPreset(const std::string& preset) {
  return preset == "paper" || preset == "wide" ? FindSharedFile("views_" + preset + ".yaml")
                                               : fs::path(preset);
}

Trajectory ReadPoses(const ViewsInput& input) {
  std::error_code error;
  if (fs::exists(input.poses, error)) {
    return ReadTum(input.poses);
  }
  if (input.poses.empty() || input.poses.front() != '/') {
    ThrowInputError("{}: no such file: expected a trajectory (TUM), or a topic of the bag",
                    input.poses);
  }
  return ReadPoseTopic(BagReader(input.bag), input.poses);
}

}  // namespace

ViewJob ReadViewsInput(const ViewsInput& input) {
  ViewJob job;
  const VinsConfig config = ReadVinsConfig(input.camera);
  job.bag = input.bag;
  job.camera = config.camera;
  job.T_B_C = input.poses_of == "body" ? config.T_B_C : Rigid3::Identity();
  job.topics.image = input.image_topic.empty() ? config.image_topic : input.image_topic;
  job.sources = EnumFromString<SourceKind>(input.sources).value();
  job.T_N_B = ReadPoses(input);
  ReadOptions(FindPreset(input.preset), &job.options);
  for (const std::string& assignment : input.overrides) {
    OverrideOption(assignment, &job.options);
  }
  job.threads = input.threads;
  return job;
}

std::shared_ptr<const nerf::FieldRenderer> ReadModel(const fs::path& path) {
  return std::make_shared<nerf::FieldRenderer>(
      std::make_shared<nerf::RadianceField>(nerf::ReadField(path)));
}

std::uint64_t HashFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    ThrowInputError("{}: can't be read", path.string());
  }
  return HashText({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
}

ViewRendererFactory WarpFactory(std::shared_ptr<const Camera> camera) {
  return [camera](const ViewSource& source, const std::vector<RangeSample>& points) {
    return std::make_shared<DepthWarpRenderer>(
        source.image, DensifyRanges(points, source.image.size()), camera, source.T_N_C);
  };
}

}  // namespace deja_view
