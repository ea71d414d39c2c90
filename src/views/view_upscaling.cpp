#include "deja_view/views/view_upscaling.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/camera/camera_parameters.hpp"

#include <algorithm>

#include "super_resolution.hpp"
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

RenderedView RenderGrey(const ViewRenderer& renderer,
                        const Camera& camera,
                        const Rigid3& T_N_V,
                        const ViewRenderOptions& options) {
  RenderedView view = renderer.Render(camera, T_N_V, options);
  if (view.image.channels() == 3) {
    cv::Mat grey;
    cv::cvtColor(view.image, grey, cv::COLOR_BGR2GRAY);
    view.image = grey;
  }
  return view;
}

/// The part of a camera's image within `part`, as a camera.
std::unique_ptr<Camera> Crop(const Camera& camera, const cv::Rect& part) {
  CameraParameters parameters = DescribeCamera(camera);
  parameters.width = part.width;
  parameters.height = part.height;
  // The principal point comes last in all models.
  const std::size_t count = parameters.projection.size();
  parameters.projection[count - 2] -= part.x;
  parameters.projection[count - 1] -= part.y;
  return MakeCamera(parameters, "crop");
}

/// Runs of tiles, row by row, that hold a corner or lie within the margin of one.
std::vector<cv::Rect> CornerTiles(const cv::Mat& image, const UpscalingOptions& options) {
  const int side = options.tile_px;
  const cv::Size tiles((image.cols + side - 1) / side, (image.rows + side - 1) / side);
  cv::Mat is_wanted = cv::Mat::zeros(tiles, CV_8UC1);
  std::vector<cv::KeyPoint> corners;
  cv::FAST(image, corners, options.corner_threshold, true);
  for (const cv::KeyPoint& corner : corners) {
    const int x = static_cast<int>(corner.pt.x);
    const int y = static_cast<int>(corner.pt.y);
    const int margin = options.corner_margin_px;
    const cv::Point first(std::max(0, x - margin) / side, std::max(0, y - margin) / side);
    const cv::Point last(std::min(image.cols - 1, x + margin) / side,
                         std::min(image.rows - 1, y + margin) / side);
    is_wanted(cv::Rect(first, last + cv::Point(1, 1))).setTo(1);
  }
  std::vector<cv::Rect> runs;
  for (int row = 0; row < tiles.height; ++row) {
    for (int begin = 0; begin < tiles.width;) {
      int end = begin;
      while (end < tiles.width && is_wanted.at<std::uint8_t>(row, end) != 0) {
        ++end;
      }
      if (end > begin) {
        runs.push_back(cv::Rect(begin * side, row * side, (end - begin) * side, side) &
                       cv::Rect({}, image.size()));
      }
      begin = end + 1;
    }
  }
  return runs;
}

void Paste(const RenderedView& part, const cv::Rect& where, RenderedView* view) {
  part.image.copyTo(view->image(where));
  part.depth.copyTo(view->depth(where));
  part.depth_variance.copyTo(view->depth_variance(where));
  part.opacity.copyTo(view->opacity(where));
}

}  // namespace

class ViewUpscaler::Network : public internal::SuperResolution {
 public:
  using SuperResolution::SuperResolution;
};

std::vector<std::string> UpscalingOptions::Validate() const {
  Requirements r;
  r.That(method != Upscaling::kFsrcnn || !network.empty(),
         "network is empty: method fsrcnn needs the file of a network");
  r.Range("corner_threshold", corner_threshold, 1, 254);
  r.Range("corner_margin_px", corner_margin_px, 0, 1000);
  r.Range("tile_px", tile_px, 4, 4096);
  return r.errors();
}

ViewUpscaler::ViewUpscaler(const UpscalingOptions& options) : options_(options) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  if (options_.method == Upscaling::kFsrcnn) {
    network_ = std::make_unique<Network>(options_.network);
  }
}

ViewUpscaler::~ViewUpscaler() = default;
ViewUpscaler::ViewUpscaler(ViewUpscaler&&) noexcept = default;
ViewUpscaler& ViewUpscaler::operator=(ViewUpscaler&&) noexcept = default;

RenderedView ViewUpscaler::Render(const ViewRenderer& renderer,
                                  const Camera& camera,
                                  const Rigid3& T_N_V,
                                  const ViewRenderOptions& options) const {
  if (options_.method == Upscaling::kDirect) {
    return RenderGrey(renderer, camera, T_N_V, options);
  }
  RenderedView view = RenderGrey(renderer, *camera.Scaled(0.5), T_N_V, options);
  const cv::Size size(camera.width(), camera.height());
  view.image = network_ != nullptr ? network_->Double(view.image, size)
                                   : ResizeFromHalf(view.image, size, cv::INTER_CUBIC);
  view.depth = ResizeFromHalf(view.depth, size, cv::INTER_NEAREST);
  view.depth_variance = ResizeFromHalf(view.depth_variance, size, cv::INTER_NEAREST);
  view.opacity = ResizeFromHalf(view.opacity, size, cv::INTER_NEAREST);
  if (options_.method == Upscaling::kPatches) {
    for (const cv::Rect& part : CornerTiles(view.image, options_)) {
      Paste(RenderGrey(renderer, *Crop(camera, part), T_N_V, options), part, &view);
    }
  }
  return view;
}

std::filesystem::path FindNetwork(const std::filesystem::path& network,
                                  const std::vector<std::filesystem::path>& directories) {
  std::error_code error;
  if (std::filesystem::is_regular_file(network, error)) {
    return network;
  }
  for (const std::filesystem::path& directory : directories) {
    if (std::filesystem::is_regular_file(directory / network, error)) {
      return directory / network;
    }
  }
  return network;
}

cv::Mat ResizeFromHalf(const cv::Mat& half, cv::Size size, int interpolation) {
  // Pixel x of the whole image lies at (x + 0.5) / 2 - 0.5 of the half.
  const cv::Matx23d to_half(0.5, 0, -0.25, 0, 0.5, -0.25);
  cv::Mat result;
  cv::warpAffine(
      half, result, to_half, size, interpolation | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  return result;
}

}  // namespace deja_view
