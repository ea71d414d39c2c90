#pragma once

#include "deja_view/views/view_renderer.hpp"

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace deja_view {

/// A pixel whose distance is known, e.g. a point that a VIO tracks.
struct RangeSample {
  Eigen::Vector2d pixel;  ///< [px]
  double range_m = 0;     ///< along the unit ray
};

/// Distance along the unit ray for every pixel.
struct RangeMap {
  cv::Mat range_m;   ///< CV_32FC1; 0: unknown
  cv::Mat variance;  ///< CV_32FC1 [m^2]
};

/// Fills an image of `size` from a few samples: the inverse range of a pixel is the mean of the
/// samples', with weights 1 / (d^2 + h^2)^2 for samples d pixels away (Shepard's interpolation, h
/// 12 px); its variance is theirs about this mean. Samples that are not positive and finite are
/// passed over; without any the map is all unknown.
RangeMap DensifyRanges(const std::vector<RangeSample>& samples, cv::Size size);

/// The ranges of a depth image [m] (CV_32FC1, 0: unknown) as they are, of 1 % standard deviation.
/// Gaps of up to about 12 px are filled with the means of the inverse ranges about them; their
/// variance is that of these, so that it is large where the gap lies along an edge. Wider ones stay
/// unknown.
RangeMap DensifyDepthImage(const cv::Mat& range_m);

/// Views near one real image without any model of the scene: the image, as a surface at its known
/// ranges, seen from elsewhere. What the image does not show is a hole: opacity 0, depth 0, and
/// filled with the nearest grey values. What a radiance field must beat.
class DepthWarpRenderer final : public ViewRenderer {
 public:
  /// `image` (CV_8UC1) and `ranges` have the camera's size. Between every `mesh_step_px`-th pixel
  /// the surface is taken to be flat, unless the ranges differ too much.
  DepthWarpRenderer(cv::Mat image,
                    RangeMap ranges,
                    std::shared_ptr<const Camera> camera,
                    const Rigid3& T_N_C,
                    int mesh_step_px = 4);

  /// The exposure applies to the real image's grey values.
  RenderedView Render(const Camera& camera,
                      const Rigid3& T_N_V,
                      const ViewRenderOptions& options) const override;

 private:
  cv::Mat image_;
  RangeMap ranges_;
  std::shared_ptr<const Camera> camera_;
  Rigid3 T_N_C_;
  int mesh_step_px_;
};

}  // namespace deja_view
