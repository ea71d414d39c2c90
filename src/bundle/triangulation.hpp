#pragma once

#include "deja_view/bundle/bundle_options.hpp"
#include "deja_view/bundle/bundle_problem.hpp"

#include <vector>

#include "image_matching.hpp"
#include "track_builder.hpp"

namespace deja_view::internal {

/// Points of tracks by the cameras as they are. Each point keeps the observations that agree with
/// it to within `error_px`, at least options.min_views under options.min_parallax_deg; where the
/// rest of a track agrees on a second point, it becomes one (the VIO's track jumped to another
/// corner).
std::vector<BundlePoint> Triangulate(const BundleOptions& options,
                                     const BundleProblem& problem,
                                     const ImageRays& rays,
                                     const std::vector<Track>& tracks,
                                     double error_px);

/// Reprojection errors [px] of a point's observations; infinite where an image does not see it.
std::vector<double> ReprojectionErrors(const BundleProblem& problem, const BundlePoint& point);

}  // namespace deja_view::internal
