#pragma once

#include "deja_view/geometry/trajectory_alignment.hpp"
#include "deja_view/views/view_renderer.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deja_view {

/// How well given poses must fit the VIO's.
struct PoseFitOptions {
  double inlier_distance_m = 0.3;  ///< poses farther off are outliers
  double max_rmse_m = 0.2;         ///< of the inliers
  double min_inlier_share = 0.5;   ///< of the poses
  double max_rotation_deg = 20;    ///< median difference of orientation

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("inlier_distance_m", inlier_distance_m);
    v("max_rmse_m", max_rmse_m);
    v("min_inlier_share", min_inlier_share);
    v("max_rotation_deg", max_rotation_deg);
  }
};

/// Where given poses lie in a world of metres.
struct PoseFrame {
  Similarity3 W_N;                     ///< from the frame of the poses (and the model)
  std::optional<RobustAlignment> fit;  ///< to the VIO's poses; nothing: it was not checked
  std::string not_checked;             ///< why; empty otherwise
};

/// Compares poses of the camera with the VIO's.
///
/// Poses with a scale keep their frame: the alignment is rigid and only tells whether they belong
/// to this flight; without VIO's poses, or where these leave the alignment open (too few, or on a
/// line), nothing is checked. Poses without a scale, as structure from motion has them, get scale
/// and frame of the VIO. Throws InputError that begins with `what` for a fit worse than `options`
/// allow, and for poses without a scale that can't be aligned.
PoseFrame FindPoseFrame(const Trajectory& T_N_C,
                        bool has_scale,
                        const std::optional<Trajectory>& T_W_C,
                        const PoseFitOptions& options,
                        const std::string& what);

/// T_N_C, in the unit of N.
Rigid3 CameraInFrame(const Similarity3& W_N, const Rigid3& T_W_C);

/// Shows in the world W what a renderer knows in its own frame N: depths come out in W's unit.
class SimilarityRenderer final : public ViewRenderer {
 public:
  /// Throws CheckError unless the scale is positive and finite.
  SimilarityRenderer(std::shared_ptr<const ViewRenderer> renderer, const Similarity3& W_N);

  RenderedView Render(const Camera& camera,
                      const Rigid3& T_W_C,
                      const ViewRenderOptions& options) const override;

 private:
  std::shared_ptr<const ViewRenderer> renderer_;
  Similarity3 W_N_;
};

/// A SimilarityRenderer, or the renderer itself where N is W.
std::shared_ptr<const ViewRenderer> PlaceInWorld(std::shared_ptr<const ViewRenderer> renderer,
                                                 const Similarity3& W_N);

}  // namespace deja_view
