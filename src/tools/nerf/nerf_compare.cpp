#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/geometry/trajectory_alignment.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/image_readers.hpp"
#include "deja_view/nerf/sparse_points.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "common/interrupt.hpp"
#include "common/pose_input.hpp"
#include "common/tool_figures.hpp"
#include "nerf/nerf_command.hpp"
#include "nerf/nerf_evaluation.hpp"
#include "nerf/nerf_options.hpp"

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

struct Source {
  std::string name;
  std::string file;
  Trajectory T_N_C;
  std::optional<RobustAlignment> alignment;
  std::vector<nerf::PosedImage> images;
};

// The camera's poses, aligned to those of the reference where there is one.
Source ReadSource(const std::string& argument,
                  bool is_of_camera,
                  const Rigid3& T_B_C,
                  const std::optional<Trajectory>& reference) {
  const std::size_t equals = argument.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == argument.size()) {
    ThrowInputError("source '{}': expected NAME=FILE", argument);
  }
  Source source;
  source.name = argument.substr(0, equals);
  source.file = argument.substr(equals + 1);
  const PoseSource poses = ReadPoses(source.file, is_of_camera);
  source.T_N_C = poses.is_of_camera ? poses.trajectory : Transform(poses.trajectory, T_B_C);
  if (reference) {
    AlignmentOptions options;
    options.freedom = poses.has_scale ? AlignmentFreedom::kRigid : AlignmentFreedom::kSimilarity;
    source.alignment = AlignTrajectories(*reference, source.T_N_C, options, source.file);
    source.T_N_C = Transform(source.alignment->A_B, source.T_N_C);
  }
  return source;
}

std::vector<Source> ReadSources(const NerfCompareRequest& request, const Rigid3& T_B_C) {
  std::optional<Trajectory> reference;
  if (!request.reference.empty()) {
    const PoseSource poses = ReadPoses(request.reference, false);
    reference = poses.is_of_camera ? poses.trajectory : Transform(poses.trajectory, T_B_C);
  }
  std::vector<Source> sources;
  for (const std::string& argument : request.sources) {
    sources.push_back(ReadSource(argument, false, T_B_C, reference));
  }
  for (const std::string& argument : request.camera_sources) {
    sources.push_back(ReadSource(argument, true, T_B_C, reference));
  }
  if (sources.empty()) {
    ThrowInputError("expected at least one --source NAME=FILE");
  }
  return sources;
}

// Gives every source the images for which all have a pose.
void ShareImages(const NerfInput& input,
                 const std::shared_ptr<const Camera>& camera,
                 std::vector<Source>* sources) {
  constexpr std::size_t kMinImages = 10;
  std::map<std::string, std::size_t> counts;
  for (Source& source : *sources) {
    source.images =
        nerf::ReadTrajectoryImages(input.images, camera, Rigid3::Identity(), source.T_N_C, true);
    for (const nerf::PosedImage& image : source.images) {
      ++counts[image.name];
    }
  }
  for (Source& source : *sources) {
    std::vector<nerf::PosedImage> shared;
    std::size_t number = 0;
    for (const nerf::PosedImage& image : source.images) {
      if (counts.at(image.name) == sources->size() &&
          number++ % static_cast<std::size_t>(input.every) == 0) {
        shared.push_back(image);
      }
    }
    source.images = std::move(shared);
  }
  if (sources->front().images.size() < kMinImages) {
    ThrowInputError("{}: all sources have a pose for {} images: expected at least {}",
                    input.images.string(),
                    sources->front().images.size(),
                    kMinImages);
  }
}

nerf::RadianceField TrainField(const NerfCompareRequest& request,
                               const Source& source,
                               const std::vector<nerf::PosedImage>& images,
                               const Interrupt& interrupt) {
  nerf::LoadOptions load_options = MakeLoadOptions(request.input, request.threads);
  load_options.channels = request.input.grey ? 1 : nerf::CountChannels(images);
  std::vector<nerf::TrainingView> views = nerf::LoadViews(images, load_options);
  nerf::AddSparsePoints({}, request.threads, &views);
  const nerf::SceneBox box = nerf::BoxAround(views, DefaultMargin(views));
  nerf::Trainer trainer(
      ReadTrainOptions(request.config, request.overrides, request.threads), std::move(views), box);
  std::optional<Progress> progress;
  const auto steps = static_cast<std::size_t>(request.steps);
  if (request.show_progress) {
    progress.emplace(source.name, "steps", steps);
  }
  for (std::size_t step = 0; step < steps; ++step) {
    interrupt.Check();
    trainer.Step(static_cast<double>(step) / request.steps);
    if (progress) {
      progress->Update(step + 1);
    }
  }
  if (progress) {
    progress->Finish(steps);
  }
  return std::move(trainer).TakeField();
}

Json Judge(const NerfCompareRequest& request, const Source& source, const Interrupt& interrupt) {
  const nerf::Split split = nerf::HoldOut(source.images, request.input.holdout);
  if (split.held_out.empty() || split.training.empty()) {
    ThrowInputError("no image is held out: expected --holdout N");
  }
  const auto start = Clock::now();
  const auto field =
      std::make_shared<nerf::RadianceField>(TrainField(request, source, split.training, interrupt));
  const double train_wall_s = SecondsSince(start);
  const nerf::FieldRenderer renderer(field);
  NerfEvaluation evaluation(
      renderer,
      MakeLoadOptions(request.input, request.threads),
      request.pictures.empty() ? request.pictures : request.pictures / source.name);
  for (const nerf::PosedImage& image : split.held_out) {
    interrupt.Check();
    evaluation.Compare(image, nullptr);
  }
  Json json;
  json["name"] = source.name;
  json["file"] = source.file;
  json["psnr_db"] = Mean(evaluation.psnr_db());
  json["ssim"] = Mean(evaluation.ssim());
  json["corner_match_rate"] = Mean(evaluation.corner_match_rate());
  json["views"] = evaluation.psnr_db().size();
  json["train_wall_s"] = train_wall_s;
  json["alignment"] = source.alignment ? ToJson(*source.alignment) : Json(nullptr);
  return json;
}

}  // namespace

Json RunNerfComparePoses(const NerfCompareRequest& request) {
  const Interrupt interrupt;
  const VinsConfig config = ReadVinsConfig(request.input.camera);
  std::vector<Source> sources = ReadSources(request, config.T_B_C);
  ShareImages(request.input, config.camera, &sources);
  Json json;
  json["images"] = sources.front().images.size();
  json["steps"] = request.steps;
  json["sources"] = Json::array();
  for (const Source& source : sources) {
    json["sources"].push_back(Judge(request, source, interrupt));
  }
  return json;
}

}  // namespace deja_view
