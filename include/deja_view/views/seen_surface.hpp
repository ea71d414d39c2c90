#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/views/view_gate.hpp"
#include "deja_view/views/view_renderer.hpp"

#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// What a camera sees of a scene's surfaces, in small.
struct SeenSurface {
  Rigid3 T_N_C;
  std::vector<Eigen::Vector3d> points_N;  ///< of a grid of pixels, those that are certain [m]
  int pixels = 0;                         ///< of the grid, certain or not
  cv::Mat depth;                          ///< CV_32FC1, along the unit ray [m]; 0: unknown
};

/// Of a render at `T_N_C` by `camera`, with a point per `step` x `step` pixels.
SeenSurface SeeSurface(const RenderedView& view,
                       const Camera& camera,
                       const Rigid3& T_N_C,
                       const GateOptions& certain,
                       int step);

/// How far a binary descriptor still knows a surface again.
struct SameLookOptions {
  double angle_deg = 20;  ///< between the two rays to a point, at which 1/e are known
  double zoom = 1.4;      ///< ratio of the two distances, or its inverse, at which 1/e are known

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("angle_deg", angle_deg);
    v("zoom", zoom);
  }
};

/// Share of what `query` sees that `known` shows as well, unhidden, each point weighed by how alike
/// it looks: exp(-(angle / angle_deg)^2 - (ln(ratio of distances) / ln(zoom))^2), and 0 beyond 2.5
/// times either, from a right angle on, and for what is beside or behind the camera. In [0, 1];
/// what is uncertain counts as unknown. Both are seen by `camera`.
double SameLook(const SeenSurface& query,
                const SeenSurface& known,
                const Camera& camera,
                const SameLookOptions& options);

}  // namespace deja_view
