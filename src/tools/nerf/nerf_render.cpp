#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/image_readers.hpp"
#include "deja_view/scene/open_scene_model.hpp"

#include <memory>
#include <optional>

#include "common/device_option.hpp"
#include "common/interrupt.hpp"
#include "common/pose_input.hpp"
#include "common/tool_figures.hpp"
#include "nerf/nerf_command.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

/// One picture to render.
struct Shot {
  std::int64_t stamp_ns = 0;  ///< 0: unknown
  std::shared_ptr<const Camera> camera;
  Rigid3 T_N_C;
};

// Along a trajectory, at even times.
std::vector<Shot> ShotsOfTrajectory(const NerfRenderRequest& request) {
  if (request.camera.empty() || request.trajectory.empty()) {
    ThrowInputError("expected --camera and --trajectory, or --transforms");
  }
  const VinsConfig config = ReadVinsConfig(request.camera);
  const std::shared_ptr<const Camera> camera = config.camera->Scaled(request.scale);
  const PoseSource poses = ReadPoses(request.trajectory, "", request.poses_of == "camera");
  const Rigid3 T_B_C = poses.is_of_camera ? Rigid3::Identity() : config.T_B_C;
  const std::vector<std::int64_t>& stamps_ns = poses.trajectory.stamps_ns;
  const auto period_ns = static_cast<std::int64_t>(1e9 / request.fps);
  std::vector<Shot> shots;
  for (std::int64_t stamp_ns = stamps_ns.front(); stamp_ns <= stamps_ns.back();
       stamp_ns += period_ns) {
    shots.push_back({stamp_ns, camera, *poses.trajectory.At(stamp_ns) * T_B_C});
  }
  return shots;
}

// The frames of a transforms.json, each with its own camera.
std::vector<Shot> ShotsOfTransforms(const NerfRenderRequest& request) {
  if (!request.camera.empty() || !request.trajectory.empty()) {
    ThrowInputError("--transforms has its own cameras and poses: expected no other");
  }
  std::vector<Shot> shots;
  for (const nerf::PosedImage& image : nerf::ReadTransforms(request.transforms, true)) {
    shots.push_back({image.stamp_ns, image.camera->Scaled(request.scale), image.T_N_C});
  }
  return shots;
}

void WriteViews(const NerfRenderRequest& request, const RenderedView& view, std::size_t number) {
  WritePng(request.out / fmt::format("{:06}.png", number), view.image);
  if (request.depth) {
    cv::Mat millimetres;
    view.depth.convertTo(millimetres, CV_16U, 1000);
    WritePng(request.out / fmt::format("{:06}.depth.png", number), millimetres);
  }
}

}  // namespace

Json RunNerfRender(const NerfRenderRequest& request) {
  const Interrupt interrupt;
  const std::vector<Shot> shots =
      request.transforms.empty() ? ShotsOfTrajectory(request) : ShotsOfTransforms(request);
  const auto model = OpenSceneModel(request.model, ChooseToolDevice(request.device));
  const auto renderer = model->RendererFor({}, {});
  std::vector<double> times_ms;
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("rendering", "views", shots.size());
  }
  for (const Shot& shot : shots) {
    interrupt.Check();
    const auto start = Clock::now();
    const SceneExposure exposure = model->ExposureAt(shot.stamp_ns);
    const RenderedView view =
        renderer->Render(*shot.camera, shot.T_N_C, {exposure.gain, exposure.bias, request.threads});
    times_ms.push_back(1e3 * SecondsSince(start));
    WriteViews(request, view, times_ms.size() - 1);
    if (progress) {
      progress->Update(times_ms.size());
    }
  }
  if (progress) {
    progress->Finish(times_ms.size());
  }
  Json json;
  json["views"] = times_ms.size();
  json["render_ms_median"] = Median(times_ms);
  json["peak_rss_mb"] = PeakRssMb();
  return json;
}

}  // namespace deja_view
