#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// How one virtual view is rendered.
struct ViewRenderOptions {
  float gain = 1.0F;       ///< exposure: displayed = gain * radiance + bias
  float bias = 0.0F;       ///< in units of white
  int threads = 0;         ///< 0: all cores; the result does not depend on it
  bool vignetting = true;  ///< darken the border as the lens of the known images does
};

/// A rendered view, height x width.
struct RenderedView {
  cv::Mat image;  ///< CV_8UC1 or CV_8UC3 (blue, green, red)
  cv::Mat depth;  ///< CV_32FC1, expected distance [m] along the unit ray; 0 where opacity is 0
  cv::Mat depth_variance;  ///< CV_32FC1 [m^2]
  cv::Mat opacity;         ///< CV_32FC1, in [0, 1]
};

/// Renders a known scene from any pose. Const and safe to call from several threads.
class ViewRenderer {
 public:
  virtual ~ViewRenderer() = default;

  /// What `camera` sees at `T_N_C`, its pose in the frame N of the scene [m].
  virtual RenderedView Render(const Camera& camera,
                              const Rigid3& T_N_C,
                              const ViewRenderOptions& options) const = 0;
};

}  // namespace deja_view
