#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// When a point triangulated from posed images is believed.
struct TrackTriangulationOptions {
  double min_depth_m = 0.1;
  double max_depth_m = 60;
  double max_error_px = 2.0;     ///< RMS of its distances to the rays, in pixels of the camera
  double pixel_sigma = 1.0;      ///< of a followed corner [px], the poses' share included
  double max_sigma_ratio = 0.1;  ///< deviation of its distance, to the distance

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_depth_m", min_depth_m);
    v("max_depth_m", max_depth_m);
    v("max_error_px", max_error_px);
    v("pixel_sigma", pixel_sigma);
    v("max_sigma_ratio", max_sigma_ratio);
  }
  std::vector<std::string> Validate() const;
};

/// What one image says of a point.
struct TrackRay {
  Eigen::Vector3d centre_W;  ///< of the camera [m]
  Eigen::Vector3d ray_W;     ///< unit vector towards the point
};

struct TriangulatedPoint {
  Eigen::Vector3d p_W;
  double sigma_ratio =
      0;  ///< standard deviation of the distance from the first ray's camera, to it
};

/// The point nearest to all rays: least squares of the distances, weighted by the inverse distance
/// from the cameras, so that they are angles; three rounds of weights. The uncertainty is that of
/// the distance along the first ray, from `pixel_sigma` and the angles between that ray and the
/// others. Nothing for a point that the options do not believe. `focal_px`: pixels per radian.
std::optional<TriangulatedPoint> TriangulateTrack(const std::vector<TrackRay>& rays,
                                                  double focal_px,
                                                  const TrackTriangulationOptions& options);

}  // namespace deja_view
