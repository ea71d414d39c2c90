#include "deja_view/views/pose_frame.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <cmath>
#include <utility>

#include <opencv2/core.hpp>

namespace deja_view {
namespace {

AlignmentOptions MakeAlignmentOptions(const PoseFitOptions& options, bool has_scale) {
  AlignmentOptions alignment;
  alignment.freedom = has_scale ? AlignmentFreedom::kRigid : AlignmentFreedom::kSimilarity;
  alignment.inlier_distance_m = options.inlier_distance_m;
  alignment.max_rmse_m = options.max_rmse_m;
  alignment.min_inlier_share = options.min_inlier_share;
  alignment.max_rotation_rad = ToRadians(options.max_rotation_deg);
  return alignment;
}

}  // namespace

std::vector<std::string> PoseFitOptions::Validate() const {
  Requirements r;
  r.That(inlier_distance_m > 0, "inlier_distance_m", inlier_distance_m, "more than 0");
  r.That(max_rmse_m > 0, "max_rmse_m", max_rmse_m, "more than 0");
  r.Range("min_inlier_share", min_inlier_share, 0, 1);
  r.That(max_rotation_deg > 0 && max_rotation_deg <= 180,
         "max_rotation_deg",
         max_rotation_deg,
         "more than 0, at most 180");
  return r.errors();
}

PoseFrame FindPoseFrame(const Trajectory& T_N_C,
                        bool has_scale,
                        const std::optional<Trajectory>& T_W_C,
                        const PoseFitOptions& options,
                        const std::string& what) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  PoseFrame frame;
  const AlignmentOptions alignment = MakeAlignmentOptions(options, has_scale);
  frame.not_checked = T_W_C ? AlignmentObstacle(*T_W_C, T_N_C, alignment) : "no poses of a VIO";
  if (frame.not_checked.empty()) {
    frame.fit = AlignTrajectories(*T_W_C, T_N_C, alignment, what);
    if (!has_scale) {
      frame.W_N = frame.fit->A_B;
    }
  } else if (!has_scale) {
    ThrowInputError("{}: poses without a scale need those of a VIO: {}", what, frame.not_checked);
  }
  return frame;
}

Rigid3 CameraInFrame(const Similarity3& W_N, const Rigid3& T_W_C) {
  Rigid3 T_N_C = W_N.T_A_B.Inverse() * T_W_C;
  T_N_C.t /= W_N.scale;
  return T_N_C;
}

SimilarityRenderer::SimilarityRenderer(std::shared_ptr<const ViewRenderer> renderer,
                                       const Similarity3& W_N)
    : renderer_(std::move(renderer)), W_N_(W_N) {
  DEJA_VIEW_CHECK(W_N.scale > 0 && std::isfinite(W_N.scale));
}

RenderedView SimilarityRenderer::Render(const Camera& camera,
                                        const Rigid3& T_W_C,
                                        const ViewRenderOptions& options) const {
  RenderedView view = renderer_->Render(camera, CameraInFrame(W_N_, T_W_C), options);
  view.depth *= W_N_.scale;
  view.depth_variance *= W_N_.scale * W_N_.scale;
  return view;
}

std::shared_ptr<const ViewRenderer> PlaceInWorld(std::shared_ptr<const ViewRenderer> renderer,
                                                 const Similarity3& W_N) {
  const Eigen::Vector4d& q = W_N.T_A_B.q.coeffs();
  if (W_N.scale == 1 && W_N.T_A_B.t.isZero(0) && q.head<3>().isZero(0)) {
    return renderer;
  }
  return std::make_shared<SimilarityRenderer>(std::move(renderer), W_N);
}

}  // namespace deja_view
