#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <optional>
#include <utility>

#include "interrupt.hpp"
#include "nerf_command.hpp"
#include "tool_figures.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

nerf::TrainOptions ReadTrainOptions(const NerfTrainRequest& request) {
  nerf::TrainOptions options;
  if (!request.config.empty()) {
    ReadOptions(request.config, &options);
  }
  for (const std::string& assignment : request.overrides) {
    OverrideOption(assignment, &options);
  }
  options.threads = request.threads;
  return options;
}

nerf::SceneBox MakeBox(const NerfTrainRequest& request,
                       const std::vector<nerf::TrainingView>& views) {
  if (request.box.empty()) {
    return nerf::BoxAround(views, request.margin);
  }
  nerf::SceneBox box;
  box.min = {request.box[0], request.box[1], request.box[2]};
  box.max = {request.box[3], request.box[4], request.box[5]};
  if (!(box.max.array() > box.min.array()).all()) {
    ThrowInputError("--box: expected each maximum to be greater than its minimum");
  }
  return box;
}

}  // namespace

Json RunNerfTrain(const NerfTrainRequest& request) {
  const auto start = Clock::now();
  Interrupt interrupt;
  const nerf::TrainOptions options = ReadTrainOptions(request);
  std::vector<nerf::TrainingView> views = LoadTrainingViews(request.input, request.threads);
  const nerf::SceneBox box = MakeBox(request, views);
  nerf::Trainer trainer(options, std::move(views), box);

  const auto train_start = Clock::now();
  const double setup_s = SecondsSince(start);
  // Time that writing the model takes; part of the budget.
  constexpr double kWriting_s = 1.5;
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("training", "krays", 0);
  }
  std::size_t rays = 0;
  std::size_t samples = 0;
  std::size_t weighted = 0;
  double psnr_db = 0;
  int steps = 0;
  bool interrupted = false;
  for (; !interrupted; ++steps) {
    const double share = request.steps > 0 ? static_cast<double>(steps) / request.steps
                                           : (SecondsSince(start) + kWriting_s - setup_s) /
                                                 (request.budget_s - setup_s);
    if (share >= 1) {
      break;
    }
    const nerf::StepReport report = trainer.Step(share);
    rays += report.rays;
    samples += report.samples;
    weighted += report.weighted;
    psnr_db += (steps == 0 ? 1.0 : 0.02) * (report.psnr_db - psnr_db);
    if (progress) {
      progress->Update(
          rays / 1000,
          fmt::format("{:.0f} %  PSNR {:.2f} dB  {:.1f} samples/ray, {:.1f} coloured",
                      100 * share,
                      psnr_db,
                      static_cast<double>(report.samples) / static_cast<double>(report.rays),
                      static_cast<double>(report.weighted) / static_cast<double>(report.rays)));
    }
    try {
      interrupt.Check();
    } catch (const Interrupted&) {
      interrupted = true;
    }
  }
  const double train_s = SecondsSince(train_start);
  if (progress) {
    progress->Finish(rays / 1000, fmt::format("PSNR {:.2f} dB", psnr_db));
  }
  nerf::WriteField(request.out, trainer.field());
  Json json;
  json["model"] = request.out.string();
  json["steps"] = steps;
  json["psnr_db"] = psnr_db;
  json["train_wall_s"] = SecondsSince(start);
  json["setup_s"] = setup_s;
  json["rays"] = rays;
  json["samples"] = samples;
  json["weighted_samples"] = weighted;
  json["rays_per_s"] = static_cast<double>(rays) / train_s;
  json["samples_per_s"] = static_cast<double>(samples) / train_s;
  json["interrupted"] = interrupted;
  json["peak_rss_mb"] = PeakRss_mb();
  return json;
}

}  // namespace deja_view
