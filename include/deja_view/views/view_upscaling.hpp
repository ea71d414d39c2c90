#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/views/view_renderer.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// How a view of full size comes about.
enum class Upscaling {
  kDirect,   ///< every pixel is rendered
  kBicubic,  ///< half the size is rendered, and interpolated
  kFsrcnn,   ///< half the size is rendered, and doubled by a network (Dong et al., ECCV 2016)
  kPatches,  ///< as bicubic, then tiles about its corners are rendered at full size
};

template <>
inline constexpr auto kEnumNames<Upscaling> = EnumNames("direct", "bicubic", "fsrcnn", "patches");

/// Options of ViewUpscaler.
struct UpscalingOptions {
  Upscaling method = Upscaling::kDirect;
  /// fsrcnn: network for a factor of 2, TensorFlow (.pb) or ONNX. The programs look for a relative
  /// path beside the preset and among the files of the package, too (FindNetwork).
  std::filesystem::path network = "super_resolution/fsrcnn_x2.onnx";
  int corner_threshold = 5;  ///< patches: of FAST, grey levels; blurred corners are weak
  int corner_margin_px = 8;  ///< patches: rendered around a corner
  int tile_px = 16;          ///< patches: side of the tiles

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("method", method);
    v("network", network);
    v("corner_threshold", corner_threshold);
    v("corner_margin_px", corner_margin_px);
    v("tile_px", tile_px);
  }
};

/// Renders grey views of full size in the chosen way. Safe to call from several threads.
class ViewUpscaler {
 public:
  /// Throws InputError that names the network's file when it can't be read, and where the method
  /// needs a part of OpenCV that this build lacks.
  explicit ViewUpscaler(const UpscalingOptions& options);
  ~ViewUpscaler();
  ViewUpscaler(ViewUpscaler&&) noexcept;
  ViewUpscaler& operator=(ViewUpscaler&&) noexcept;

  /// What `camera` sees; the image is CV_8UC1. Depth, variance and opacity of a view that was
  /// rendered at half the size are those of the nearest pixel. Throws InputError for a network
  /// whose output is not twice its input's size.
  RenderedView Render(const ViewRenderer& renderer,
                      const Camera& camera,
                      const Rigid3& T_N_V,
                      const ViewRenderOptions& options) const;

 private:
  class Network;
  UpscalingOptions options_;
  std::unique_ptr<Network> network_;
};

/// `network`, or, where there is no such file, the first of that name in `directories`; `network`
/// itself where there is none at all.
std::filesystem::path FindNetwork(const std::filesystem::path& network,
                                  const std::vector<std::filesystem::path>& directories);

/// Doubles an image (CV_8UC1 or CV_32FC1) to `size` with pixel centres where Camera::Scaled(0.5)
/// puts them; `interpolation` is OpenCV's.
cv::Mat ResizeFromHalf(const cv::Mat& half, cv::Size size, int interpolation);

}  // namespace deja_view
