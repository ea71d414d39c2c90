#pragma once

#include <string>
#include <vector>

namespace deja_view {

/// What of each camera is adjusted beside the poses.
struct BundleRefinement {
  bool intrinsics = false;   ///< focal lengths, principal point, MEI's xi
  bool distortion = false;   ///< all coefficients
  bool extrinsics = false;   ///< T_B_C
  bool time_offset = false;  ///< needs velocities and priors of poses

  bool Any() const { return intrinsics || distortion || extrinsics || time_offset; }

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("intrinsics", intrinsics);
    v("distortion", distortion);
    v("extrinsics", extrinsics);
    v("time_offset", time_offset);
  }
};

/// How far cameras may be from what is given (standard deviations).
struct BundleCameraSigmas {
  double focal = 0.02;           ///< of the focal length, and of MEI's xi absolutely
  double centre_px = 10.0;       ///< principal point
  double distortion = 0.05;      ///< each coefficient
  double extrinsic_m = 0.02;     ///< per axis
  double extrinsic_deg = 1.0;    ///< per axis
  double time_offset_s = 0.010;  ///< [s]

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("focal", focal);
    v("centre_px", centre_px);
    v("distortion", distortion);
    v("extrinsic_m", extrinsic_m);
    v("extrinsic_deg", extrinsic_deg);
    v("time_offset_s", time_offset_s);
  }
};

/// Options of AdjustBundle.
struct BundleOptions {
  // Which images are matched, and how.
  int neighbours = 3;              ///< images before each that it is matched with
  int overlapping = 10;            ///< others that look the same way from nearby, per image
  double max_view_deg = 40.0;      ///< between the optical axes of such images
  double reach_m = 2.0;            ///< between their cameras
  int max_hamming = 60;            ///< [bit] of 256
  double max_hamming_ratio = 0.9;  ///< nearest over second nearest descriptor
  // Per round from the first to the last, which the tolerances approach geometrically.
  int rounds = 4;
  double first_error_px = 8.0;  ///< epipolar distance, reprojection error and search radius
  double last_error_px = 2.5;   ///< [px]
  // Points.
  double min_parallax_deg = 1.5;  ///< between two rays of a point
  int min_views = 3;              ///< images that see a point
  int points_per_image = 80;      ///< adjusted, at least where an image sees so many; 0: all
  int min_points = 10;            ///< an image that sees fewer rests on its priors
  // Solver.
  int max_iterations = 12;           ///< per round
  double pixel_sigma = 0.7;          ///< [px] of a corner
  double kernel_sigmas = 2.0;        ///< Cauchy kernel
  double prior_kernel_sigmas = 4.0;  ///< of the priors of poses: an odometry may jump
  double tolerance = 3e-4;           ///< relative decrease of the cost that ends a round
  int threads = 0;  ///< for matching; 0: all cores. The result does not depend on it
  BundleRefinement refine;
  BundleCameraSigmas camera_sigmas;

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("neighbours", neighbours);
    v("overlapping", overlapping);
    v("max_view_deg", max_view_deg);
    v("reach_m", reach_m);
    v("max_hamming", max_hamming);
    v("max_hamming_ratio", max_hamming_ratio);
    v("rounds", rounds);
    v("first_error_px", first_error_px);
    v("last_error_px", last_error_px);
    v("min_parallax_deg", min_parallax_deg);
    v("min_views", min_views);
    v("points_per_image", points_per_image);
    v("min_points", min_points);
    v("max_iterations", max_iterations);
    v("pixel_sigma", pixel_sigma);
    v("kernel_sigmas", kernel_sigmas);
    v("prior_kernel_sigmas", prior_kernel_sigmas);
    v("tolerance", tolerance);
    v("threads", threads);
    v("refine", refine);
    v("camera_sigmas", camera_sigmas);
  }
};

}  // namespace deja_view
