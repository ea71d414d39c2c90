#pragma once

#include "deja_view/views/view_renderer.hpp"

#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// Where a virtual view may be, and how sure its render must be.
struct GateOptions {
  bool free_space = true;  ///< ask that the virtual camera is in observed free space: within
  double flown_m = 0.1;    ///< this distance of the flown path, or
  double clearance_m =
      0.15;                  ///< as seen from the real camera so much nearer than what is behind it
  double min_opacity = 0.9;  ///< a pixel is certain when its opacity is at least this
  double max_depth_sigma = 0.1;  ///< and its depth's standard deviation over its depth at most this
  double min_certain_share = 0.75;  ///< of the pixels that must be certain; 0: any render will do
  double scale = 0.125;             ///< size of the small render that decides

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("free_space", free_space);
    v("flown_m", flown_m);
    v("clearance_m", clearance_m);
    v("min_opacity", min_opacity);
    v("max_depth_sigma", max_depth_sigma);
    v("min_certain_share", min_certain_share);
    v("scale", scale);
  }
};

/// Why a virtual pose was passed over.
enum class GateVerdict { kAccepted, kNotFree, kUncertain };

/// Whether the pixel's opacity and depth are certain.
bool IsCertain(const RenderedView& view, int x, int y, const GateOptions& options);

/// Share of a render's pixels whose opacity and depth are certain.
double CertainShare(const RenderedView& view, const GateOptions& options);

/// Certainty of each pixel, CV_8UC1: 255 opacity / (1 + (sigma / (limit depth))^2), with the limit
/// that the gate sets; 0 where the depth is unknown.
cv::Mat CertaintyOf(const RenderedView& view, const GateOptions& options);

/// Decides about virtual poses by small renders. Safe to call from several threads.
class ViewGate {
 public:
  /// `flown_N`: positions of the camera along the flight, in order [m]; may be empty.
  ViewGate(const GateOptions& options,
           std::shared_ptr<const Camera> camera,
           std::vector<Eigen::Vector3d> flown_N);

  /// `small`, where wanted, gets the small render, unless the pose is not free.
  GateVerdict Judge(const ViewRenderer& renderer,
                    const Rigid3& T_N_C,
                    const Rigid3& T_C_V,
                    RenderedView* small = nullptr) const;

  const Camera& small_camera() const { return *small_camera_; }

 private:
  bool IsNearPath(const Eigen::Vector3d& p_N) const;
  bool IsInSight(const ViewRenderer& renderer,
                 const Rigid3& T_N_C,
                 const Eigen::Vector3d& p_C) const;

  GateOptions options_;
  std::shared_ptr<const Camera> small_camera_;
  std::vector<Eigen::Vector3d> flown_N_;
};

}  // namespace deja_view
