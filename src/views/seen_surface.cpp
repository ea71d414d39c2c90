#include "deja_view/views/seen_surface.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/requirements.hpp"

#include <cmath>

namespace deja_view {
namespace {

/// Whether `known` has this surface at its pixel, not one before or behind it.
bool IsShown(const SeenSurface& known, const Eigen::Vector2d& pixel, double distance) {
  constexpr double kAgreement = 0.1;  // of the depth
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  if (x < 0 || y < 0 || x >= known.depth.cols || y >= known.depth.rows) {
    return false;
  }
  const auto depth = static_cast<double>(known.depth.at<float>(y, x));
  return depth > 0 && std::abs(depth - distance) <= kAgreement * distance;
}

}  // namespace

std::vector<std::string> SameLookOptions::Validate() const {
  Requirements r;
  r.That(angle_deg > 0 && angle_deg <= 180, "angle_deg", angle_deg, "more than 0, at most 180");
  r.That(zoom > 1 && std::isfinite(zoom), "zoom", zoom, "more than 1");
  return r.errors();
}

SeenSurface SeeSurface(const RenderedView& view,
                       const Camera& camera,
                       const Rigid3& T_N_C,
                       const GateOptions& certain,
                       int step) {
  SeenSurface seen;
  seen.T_N_C = T_N_C;
  seen.depth = view.depth.clone();
  for (int y = step / 2; y < view.depth.rows; y += step) {
    for (int x = step / 2; x < view.depth.cols; x += step) {
      ++seen.pixels;
      if (IsCertain(view, x, y, certain)) {
        const auto depth = static_cast<double>(view.depth.at<float>(y, x));
        seen.points_N.push_back(
            T_N_C * (depth * camera.Unproject({static_cast<double>(x), static_cast<double>(y)})));
      }
    }
  }
  return seen;
}

double SameLook(const SeenSurface& query,
                const SeenSurface& known,
                const Camera& camera,
                const SameLookOptions& options) {
  constexpr double kFar = 2.5;  // in angles or zooms: e^-6.25, next to nothing
  const Eigen::Quaterniond q_K_N = known.T_N_C.q.conjugate();
  const Eigen::Vector3d ahead_N = known.T_N_C.q * Eigen::Vector3d::UnitZ();
  const double least_cosine = std::cos(std::min(kPi / 2, kFar * options.angle_deg * kDegree));
  const double most_zoom = std::pow(options.zoom, 2 * kFar);  // of squares
  const double per_angle = 1 / (options.angle_deg * kDegree);
  const double per_zoom = 1 / std::log(options.zoom);
  double sum = 0;
  for (const Eigen::Vector3d& p_N : query.points_N) {
    // Most points end here, before a root is drawn or anything projected.
    const Eigen::Vector3d from_query = p_N - query.T_N_C.t;
    const Eigen::Vector3d from_known = p_N - known.T_N_C.t;
    const double a = from_query.squaredNorm();
    const double b = from_known.squaredNorm();
    const double dot = from_query.dot(from_known);
    if (from_known.dot(ahead_N) <= 0 || a > most_zoom * b || b > most_zoom * a || dot < 0 ||
        dot * dot < least_cosine * least_cosine * a * b) {
      continue;
    }
    const std::optional<Eigen::Vector2d> pixel = camera.Project(q_K_N * from_known);
    if (!pixel || !IsShown(known, *pixel, std::sqrt(b))) {
      continue;
    }
    const double angle = per_angle * std::acos(std::min(1.0, dot / std::sqrt(a * b)));
    const double zoom = per_zoom * 0.5 * std::log(a / b);
    sum += std::exp(-angle * angle - zoom * zoom);
  }
  return query.pixels > 0 ? sum / query.pixels : 0.0;
}

}  // namespace deja_view
