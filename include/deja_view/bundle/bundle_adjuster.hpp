#pragma once

#include "deja_view/bundle/bundle_options.hpp"
#include "deja_view/bundle/bundle_problem.hpp"

#include <functional>
#include <string>
#include <vector>

namespace deja_view {

/// One round of matching, triangulation and adjustment.
struct BundleRound {
  double error_px = 0;  ///< tolerance
  int pairs = 0;        ///< of images, with matches
  int matches = 0;
  int tracks = 0;           ///< of two keypoints or more
  int points = 0;           ///< triangulated
  int adjusted_points = 0;  ///< of them, those that entered the adjustment
  int observations = 0;     ///< of the adjusted points
  int iterations = 0;
  double rms_before_px = 0;  ///< of the adjusted points
  double rms_after_px = 0;
  double matching_s = 0;  ///< wall time
  double solving_s = 0;   ///< wall time
};

/// What AdjustBundle did.
struct BundleSummary {
  /// Why nothing was adjusted and the problem is as it was; empty when it was.
  std::string obstacle;
  std::vector<BundleRound> rounds;  ///< that were finished
  bool was_stopped = false;         ///< before the last of options.rounds
  int images = 0;
  int weak_images = 0;  ///< see fewer than min_points points: they rest on their priors
  int points = 0;       ///< of the result
  int observations = 0;
  double rms_px = 0;           ///< of all points of the result
  double median_px = 0;        ///< of the observations' errors
  double mean_track = 0;       ///< observations per point
  double mean_shift_m = 0;     ///< of the images
  double largest_shift_m = 0;  ///< of an image
  bool is_usable() const { return obstacle.empty(); }

  /// A line per round, then the result or the obstacle.
  std::string ToString() const;
};

/// Bundle adjustment of a whole flight: matches corners of images whose poses say that they see the
/// same things, joins the matches and the VIO's tracks, triangulates, adjusts poses, points and
/// what `options.refine` asks for, drops what does not fit, and begins again with the better poses
/// and narrower tolerances.
///
/// Deterministic, whatever `options.threads`: matching and triangulation write per index, the
/// solver runs in one thread. Input from which nothing can be learnt (no parallax, too few
/// corners) leaves the problem as it was, with an obstacle; images that see too little rest on
/// their priors, which must then connect them. Throws CheckError for invalid options and for
/// indices, sizes or values that make no problem.
///
/// `on_progress` hears in the caller's thread which share of the work is done, and stops it by
/// false: the problem is then as the last finished round left it.
BundleSummary AdjustBundle(const BundleOptions& options,
                           BundleProblem* problem,
                           const std::function<void(const BundleRound&)>& on_round = {},
                           const std::function<bool(double share)>& on_progress = {});

/// Covariances (t_W_B [m], rotation vector [rad] in W) of the poses of `images`, all else
/// marginalised, in the problem as it is. Takes a sparse factorisation of all poses and a solution
/// per image.
std::vector<Eigen::Matrix<double, 6, 6>> PoseCovariances(const BundleOptions& options,
                                                         const BundleProblem& problem,
                                                         const std::vector<int>& images);

}  // namespace deja_view
