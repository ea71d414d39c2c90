#include "deja_view/base/progress.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/image_metrics.hpp"
#include "deja_view/nerf/posed_images.hpp"

#include <memory>
#include <optional>

#include "interrupt.hpp"
#include "nerf_command.hpp"
#include "tool_figures.hpp"
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

cv::Mat SideBySide(const cv::Mat& real, const cv::Mat& rendered) {
  cv::Mat difference;
  cv::absdiff(real, rendered, difference);
  cv::Mat picture;
  cv::hconcat(std::vector<cv::Mat>{real, rendered, 2 * difference}, picture);
  return picture;
}

cv::Mat ToGrey(const cv::Mat& image) {
  if (image.channels() == 1) {
    return image;
  }
  cv::Mat grey;
  cv::extractChannel(image, grey, 1);
  return grey;
}

}  // namespace

Json RunNerfEval(const NerfEvalRequest& request) {
  Interrupt interrupt;
  const auto field = std::make_shared<nerf::RadianceField>(nerf::ReadField(request.model));
  const nerf::FieldRenderer renderer(field, nerf::FindKernels(request.kernels));
  std::vector<nerf::PosedImage> images = ReadNerfInput(request.input).held_out;
  if (request.views > 0 && images.size() > static_cast<std::size_t>(request.views)) {
    images.resize(static_cast<std::size_t>(request.views));
  }
  const std::vector<nerf::TrainingView> views =
      nerf::LoadViews(images, field->channels, request.input.scale, request.threads);
  std::vector<double> psnr, ssim, corners, times;
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("rendering", "views", views.size());
  }
  for (const nerf::TrainingView& view : views) {
    interrupt.Check();
    const nerf::Exposure exposure = renderer.ExposureAt(view.stamp_ns);
    const auto start = Clock::now();
    const RenderedView rendered =
        renderer.Render(*view.camera, view.T_N_C, {exposure.gain, exposure.bias, request.threads});
    times.push_back(1e3 * SecondsSince(start));
    psnr.push_back(nerf::Psnr(view.image, rendered.image));
    ssim.push_back(nerf::Ssim(view.image, rendered.image));
    corners.push_back(nerf::CornerMatchRate(ToGrey(view.image), ToGrey(rendered.image)));
    if (!request.pictures.empty()) {
      WritePng(request.pictures / (view.name + ".png"), SideBySide(view.image, rendered.image));
    }
    if (progress) {
      progress->Update(psnr.size());
    }
  }
  if (progress) {
    progress->Finish(psnr.size());
  }
  Json json;
  json["psnr_db"] = Mean(psnr);
  json["ssim"] = Mean(ssim);
  json["corner_match_rate"] = Mean(corners);
  json["views"] = psnr.size();
  json["render_ms_median"] = Median(times);
  json["peak_rss_mb"] = PeakRss_mb();
  return json;
}

}  // namespace deja_view
