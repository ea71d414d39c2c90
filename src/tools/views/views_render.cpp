#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/base/output_lock.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/scene/open_scene_model.hpp"

#include <algorithm>
#include <iostream>
#include <optional>

#include "common/device_option.hpp"
#include "common/interrupt.hpp"
#include "common/tool_figures.hpp"
#include "views/views_command.hpp"
#include "views/views_input.hpp"

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

ViewContent ParseContent(const ViewsRenderRequest& request) {
  ViewContent content;
  content.image = request.content != "features";
  content.features = request.content != "image";
  content.depth = request.depth;
  return content;
}

// All that decides what the views look like, but the flight.
std::string DescribeSettings(const ViewsRenderRequest& request,
                             const ViewOptions& options,
                             const ViewModel& model) {
  std::string text = fmt::format("renderer: {}\ncontent: {}\ndepth: {}\n{}",
                                 request.renderer,
                                 request.content,
                                 request.depth,
                                 model.settings);
  ViewOptions named = options;
  if (options.rendering.method == Upscaling::kFsrcnn) {
    text += fmt::format("network: {:016x}\n", Hash64OfFile(options.rendering.network));
  }
  // The same views wherever the package is installed.
  named.rendering.network = options.rendering.network.filename();
  return text + OptionsToYaml(named);
}

// Throws InputError where the flight lacks what the model works by.
void CheckPoints(const ViewsRenderRequest& request, const ViewJob& job, const SceneModel& model) {
  const std::string& points = job.topics.keyframe_point;
  if (model.NeedsPoints() && !job.flight->HasTopic(points)) {
    ThrowInputError(
        "{}: no topic '{}': expected the VIO's points, by which --renderer {} works, or "
        "--depth-maps",
        job.flight->path().string(),
        points,
        request.renderer);
  }
}

// An image that is warped knows nothing of what is about it.
void CheckChoice(const ViewsRenderRequest& request, const ViewJob& job) {
  if (job.options.choice.by == ChoiceKind::kNeed && request.renderer != "nerf") {
    ThrowInputError("--preset {}: choice.by: need goes with --renderer nerf, found {}",
                    request.input.preset,
                    request.renderer);
  }
}

// Depth is warped on the CPU.
nerf::DeviceChoice DeviceOf(const ViewsRenderRequest& request) {
  return request.renderer == "nerf" ? ChooseToolDevice(request.device) : nerf::DeviceChoice();
}

void TellSubMap(const Shard& sub_map) {
  if (sub_map.count > 1) {
    std::cerr << fmt::format(
        "sub-map {} of {}: views of its own images, for `deja_view views merge` with the others'\n",
        sub_map.index,
        sub_map.count);
  }
}

// A resumed run counts only what it still has to do, so that rate and time left are right.
class StepProgress {
 public:
  explicit StepProgress(bool is_shown) : is_shown_(is_shown) {}

  void Update(ViewStep step, std::size_t done, std::size_t total) {
    if (!is_shown_) {
      return;
    }
    if (!progress_ || step != step_) {
      step_ = step;
      first_ = step == ViewStep::kRendering ? done : 0;
      step == ViewStep::kRendering ? progress_.emplace("virtual views", "images", total - first_)
                                   : progress_.emplace("choosing views", "rounds", total);
    }
    done == total ? progress_->Finish(done - first_) : progress_->Update(done - first_);
  }

 private:
  bool is_shown_;
  ViewStep step_ = ViewStep::kChoosing;
  std::size_t first_ = 0;
  std::optional<Progress> progress_;
};

double PerView(const ViewReport& report) {
  return report.views > 0 ? static_cast<double>(report.bytes) / static_cast<double>(report.views)
                          : 0.0;
}

}  // namespace

Json RunViewsRender(const ViewsRenderRequest& request) {
  const auto start = Clock::now();
  const Interrupt interrupt;
  const OutputLock lock = OutputLock::OfFile(request.out);
  PosedJob posed = ReadViewsInput(request.input);
  ViewJob& job = posed.job;
  job.out = request.out;
  job.shard = ParseShard("--shard", request.shard);
  job.content = ParseContent(request);
  job.plain_topics = request.plain_topics;
  job.views_only = request.views_only;
  job.resume = request.resume;
  const auto maps = OpenFlightMaps(request.input.depth_maps, job);
  const auto scene =
      OpenSceneModel({request.renderer, request.input.model, job.camera, maps, DeviceOf(request)});
  CheckPoints(request, job, *scene);
  CheckChoice(request, job);
  scene->Relax(&job.options.gate);
  const ViewModel model = PlaceModel(scene, posed);
  if (request.input.show_progress) {
    TellSubMap(model.sub_map.shard);
  }
  job.sub_map = model.sub_map;
  job.settings = DescribeSettings(request, job.options, model);
  StepProgress progress(request.input.show_progress);
  const ViewReport report =
      RenderViews(job, model.renderers, [&](ViewStep step, std::size_t done, std::size_t total) {
        progress.Update(step, done, total);
        interrupt.Check();
      });
  Json json;
  json["alignment"] = ToJson(posed.poses);
  if (job.sub_map.shard.count > 1) {
    json["sub_map"] = fmt::format("{}/{}", job.sub_map.shard.index, job.sub_map.shard.count);
  }
  if (maps != nullptr) {
    json["depth_maps"] = CountDepthMaps(*maps, job);
  }
  json["images"] = report.images;
  json["without_pose"] = report.without_pose;
  json["sources"] = report.sources;
  json["resumed"] = report.resumed;
  json["not_recognised"] = report.not_recognised;
  json["views"] = report.views;
  json["not_free"] = report.not_free;
  json["uncertain"] = report.uncertain;
  json["bytes_per_view"] = PerView(report);
  json["source_psnr_db"] = Mean(report.source_psnr_db);
  json["source_ms_median"] = 1e3 * Median(report.source_s);
  json["wall_s"] = SecondsSince(start);
  json["cpu_s"] = CpuSeconds();
  json["peak_rss_mb"] = PeakRssMb();
  return json;
}

Json RunViewsMerge(const ViewsMergeRequest& request) {
  const OutputLock lock = OutputLock::OfFile(request.out);
  const ViewReport report =
      MergeViews(*OpenFlight(request.flight), request.parts, request.out, request.views_only);
  Json json;
  json["views"] = report.views;
  json["bytes_per_view"] = PerView(report);
  return json;
}

}  // namespace deja_view
