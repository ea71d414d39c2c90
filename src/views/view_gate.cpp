#include "deja_view/views/view_gate.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view {
namespace {

// A pencil of rays about one direction: 4 x 4 of them, 6 degrees wide.
constexpr int kPencilSide = 4;
constexpr double kPencilFocal_px = 38;

double DistanceToSegment(const Eigen::Vector3d& p,
                         const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b) {
  const Eigen::Vector3d d = b - a;
  const double length = d.squaredNorm();
  const double u = length > 0 ? std::clamp((p - a).dot(d) / length, 0.0, 1.0) : 0.0;
  return (p - a - u * d).norm();
}

}  // namespace

std::vector<std::string> GateOptions::Validate() const {
  Requirements r;
  r.That(flown_m >= 0 && flown_m <= 1e6, "flown_m", flown_m, "0 or more");
  r.That(clearance_m >= 0 && clearance_m <= 1e6, "clearance_m", clearance_m, "0 or more");
  r.Range("min_opacity", min_opacity, 0, 1);
  r.That(max_depth_sigma > 0, "max_depth_sigma", max_depth_sigma, "more than 0");
  r.Range("min_certain_share", min_certain_share, 0, 1);
  r.Range("scale", scale, 0.01, 1);
  return r.errors();
}

bool IsCertain(const RenderedView& view, int x, int y, const GateOptions& options) {
  const float depth = view.depth.at<float>(y, x);
  return depth > 0 && view.opacity.at<float>(y, x) >= static_cast<float>(options.min_opacity) &&
         std::sqrt(view.depth_variance.at<float>(y, x)) <=
             static_cast<float>(options.max_depth_sigma) * depth;
}

double CertainShare(const RenderedView& view, const GateOptions& options) {
  std::size_t certain = 0;
  for (int y = 0; y < view.depth.rows; ++y) {
    for (int x = 0; x < view.depth.cols; ++x) {
      certain += IsCertain(view, x, y, options) ? 1U : 0U;
    }
  }
  return static_cast<double>(certain) / static_cast<double>(view.depth.total());
}

cv::Mat CertaintyOf(const RenderedView& view, const GateOptions& options) {
  cv::Mat certainty = cv::Mat::zeros(view.depth.size(), CV_8UC1);
  for (int y = 0; y < view.depth.rows; ++y) {
    for (int x = 0; x < view.depth.cols; ++x) {
      const float depth = view.depth.at<float>(y, x);
      if (depth > 0) {
        const float limit = static_cast<float>(options.max_depth_sigma) * depth;
        const float relative = view.depth_variance.at<float>(y, x) / (limit * limit);
        certainty.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(
            std::lround(255.0F * view.opacity.at<float>(y, x) / (1 + relative)));
      }
    }
  }
  return certainty;
}

ViewGate::ViewGate(const GateOptions& options,
                   std::shared_ptr<const Camera> camera,
                   std::vector<Eigen::Vector3d> flown_N)
    : options_(options),
      small_camera_(camera->Scaled(options.scale)),
      flown_N_(std::move(flown_N)) {
  DEJA_VIEW_CHECK(options.Validate().empty());
}

GateVerdict ViewGate::Judge(const ViewRenderer& renderer,
                            const Rigid3& T_N_C,
                            const Rigid3& T_C_V,
                            RenderedView* small) const {
  if (options_.free_space && !IsNearPath(T_N_C * T_C_V.t) && !IsInSight(renderer, T_N_C, T_C_V.t)) {
    return GateVerdict::kNotFree;
  }
  if (options_.min_certain_share <= 0 && small == nullptr) {
    return GateVerdict::kAccepted;
  }
  RenderedView view = renderer.Render(*small_camera_, T_N_C * T_C_V, {1, 0, 1});
  const bool is_certain = CertainShare(view, options_) >= options_.min_certain_share;
  if (small != nullptr) {
    *small = std::move(view);
  }
  return is_certain ? GateVerdict::kAccepted : GateVerdict::kUncertain;
}

bool ViewGate::IsNearPath(const Eigen::Vector3d& p_N) const {
  for (std::size_t i = 0; i < flown_N_.size(); ++i) {
    const Eigen::Vector3d& next = flown_N_[std::min(i + 1, flown_N_.size() - 1)];
    // Images far apart say nothing about what is between them.
    const bool is_joined = (next - flown_N_[i]).norm() <= 1.0;
    if (DistanceToSegment(p_N, flown_N_[i], is_joined ? next : flown_N_[i]) <= options_.flown_m) {
      return true;
    }
  }
  return false;
}

bool ViewGate::IsInSight(const ViewRenderer& renderer,
                         const Rigid3& T_N_C,
                         const Eigen::Vector3d& p_C) const {
  const double distance = p_C.norm();
  if (distance == 0) {
    return true;
  }
  const double centre = 0.5 * (kPencilSide - 1);
  const PinholeCamera pencil(PinholeParameters{
      kPencilSide, kPencilSide, kPencilFocal_px, kPencilFocal_px, centre, centre, 0, 0, 0, 0});
  const Rigid3 T_C_P{Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), p_C),
                     Eigen::Vector3d::Zero()};
  const RenderedView view = renderer.Render(pencil, T_N_C * T_C_P, {1, 0, 1});
  for (int y = 0; y < kPencilSide; ++y) {
    for (int x = 0; x < kPencilSide; ++x) {
      const double near = static_cast<double>(view.depth.at<float>(y, x)) -
                          std::sqrt(static_cast<double>(view.depth_variance.at<float>(y, x)));
      if (view.opacity.at<float>(y, x) < static_cast<float>(options_.min_opacity) ||
          near < distance + options_.clearance_m) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace deja_view
