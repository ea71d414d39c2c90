#include "nerf/nerf_evaluation.hpp"

#include "deja_view/nerf/depth_metrics.hpp"
#include "deja_view/nerf/image_metrics.hpp"

#include <utility>

#include "common/tool_figures.hpp"
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

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

NerfEvaluation::NerfEvaluation(const nerf::FieldRenderer& renderer,
                               const nerf::LoadOptions& load_options,
                               const std::filesystem::path& pictures)
    : renderer_(renderer), load_options_(load_options), pictures_(pictures) {
  load_options_.channels = renderer.field().channels;
  load_options_.depth_step_px = 0;
}

void NerfEvaluation::Compare(const nerf::PosedImage& image, const nerf::PosedImage* neighbour) {
  const nerf::TrainingView real = Load(image);
  const RenderedView rendered = Render(real);
  psnr_db_.push_back(nerf::Psnr(real.image, rendered.image));
  ssim_.push_back(nerf::Ssim(real.image, rendered.image));
  corner_match_rate_.push_back(nerf::CornerMatchRate(ToGrey(real.image), ToGrey(rendered.image)));
  if (neighbour != nullptr) {
    const cv::Mat warped =
        nerf::WarpImage(Load(*neighbour), *real.camera, real.T_N_C, rendered.depth);
    corner_match_ceiling_.push_back(nerf::CornerMatchRate(ToGrey(real.image), ToGrey(warped)));
  }
  if (!pictures_.empty()) {
    WritePng(pictures_ / (image.name + ".png"), SideBySide(real.image, rendered.image));
  }
  CompareDepth(image, rendered);
}

void NerfEvaluation::CompareDepthOnly(const nerf::PosedImage& image) {
  CompareDepth(image, Render(Load(image)));
}

nerf::TrainingView NerfEvaluation::Load(const nerf::PosedImage& image) const {
  return std::move(nerf::LoadViews({image}, load_options_).front());
}

RenderedView NerfEvaluation::Render(const nerf::TrainingView& real) {
  const nerf::Exposure exposure = renderer_.ExposureAt(real.stamp_ns);
  const auto start = Clock::now();
  RenderedView rendered = renderer_.Render(
      *real.camera, real.T_N_C, {exposure.gain, exposure.bias, load_options_.threads});
  render_ms_.push_back(1e3 * SecondsSince(start));
  return rendered;
}

void NerfEvaluation::CompareDepth(const nerf::PosedImage& image, const RenderedView& rendered) {
  if (image.depth.path.empty()) {
    return;
  }
  cv::Mat depth = rendered.depth;
  if (image.depth.camera) {
    depth = renderer_.Render(*image.depth.camera, image.T_N_C, {1, 0, load_options_.threads}).depth;
  }
  const auto errors = nerf::RelativeDepthErrors(nerf::ReadDepthMap(image), depth);
  depth_errors_.insert(depth_errors_.end(), errors.begin(), errors.end());
  ++depth_views_;
}

}  // namespace deja_view
