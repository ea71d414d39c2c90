#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/field_renderer.hpp"

#include <memory>
#include <optional>

#include "interrupt.hpp"
#include "nerf_command.hpp"
#include "tool_figures.hpp"
#include <fmt/format.h>

namespace deja_view {

using Json = nlohmann::ordered_json;

Json RunNerfRender(const NerfRenderRequest& request) {
  Interrupt interrupt;
  const auto field = std::make_shared<nerf::RadianceField>(nerf::ReadField(request.model));
  const nerf::FieldRenderer renderer(field);
  const VinsConfig config = ReadVinsConfig(request.camera);
  const std::shared_ptr<const Camera> camera = config.camera->Scaled(request.scale);
  const Rigid3 T_B_C = request.poses_of == "body" ? config.T_B_C : Rigid3::Identity();
  const Trajectory trajectory = ReadTum(request.trajectory);
  if (trajectory.empty()) {
    ThrowInputError("{}: holds no pose", request.trajectory.string());
  }
  const auto period_ns = static_cast<std::int64_t>(1e9 / request.fps);
  std::vector<double> times;
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("rendering", "views", 0);
  }
  std::size_t count = 0;
  for (std::int64_t stamp_ns = trajectory.stamps_ns.front();
       stamp_ns <= trajectory.stamps_ns.back();
       stamp_ns += period_ns) {
    interrupt.Check();
    const std::optional<Rigid3> T_N_B = trajectory.At(stamp_ns);
    const auto start = Clock::now();
    const nerf::Exposure exposure = renderer.ExposureAt(stamp_ns);
    const RenderedView view =
        renderer.Render(*camera, *T_N_B * T_B_C, {exposure.gain, exposure.bias, request.threads});
    times.push_back(1e3 * SecondsSince(start));
    WritePng(request.out / fmt::format("{:06}.png", count), view.image);
    if (request.depth) {
      cv::Mat millimetres;
      view.depth.convertTo(millimetres, CV_16U, 1000);
      WritePng(request.out / fmt::format("{:06}.depth.png", count), millimetres);
    }
    ++count;
    if (progress) {
      progress->Update(count);
    }
  }
  if (progress) {
    progress->Finish(count);
  }
  Json json;
  json["views"] = count;
  json["render_ms_median"] = Median(times);
  json["peak_rss_mb"] = PeakRss_mb();
  return json;
}

}  // namespace deja_view
