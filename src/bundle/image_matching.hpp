#pragma once

#include "deja_view/bundle/bundle_options.hpp"
#include "deja_view/bundle/bundle_problem.hpp"

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace deja_view::internal {

/// Two keypoints that may show the same corner.
struct KeypointMatch {
  BundleObservation a;
  BundleObservation b;
  int distance = 0;  ///< [bit]
};

/// Mutually nearest descriptors of each pair of images, in the order of the pairs. `goes_on` hears
/// which share is done; false from it ends the work.
std::vector<KeypointMatch> MatchDescriptors(const BundleOptions& options,
                                            const BundleProblem& problem,
                                            const std::vector<std::pair<int, int>>& pairs,
                                            const std::function<bool(double share)>& goes_on = {});

/// Unit vectors in C towards every keypoint of every image, with the cameras as they are.
using ImageRays = std::vector<std::vector<Eigen::Vector3d>>;
ImageRays UnprojectKeypoints(const BundleProblem& problem, int threads);

/// Those matches whose rays meet to within `error_px`: each lies so near to the plane through the
/// other and both cameras, or, where the cameras stand together, to the other itself. Matches of
/// the problem's loops may agree with the loop's relative pose instead, while `use_loops`.
std::vector<KeypointMatch> KeepEpipolar(const BundleOptions& options,
                                        const BundleProblem& problem,
                                        const ImageRays& rays,
                                        const std::vector<KeypointMatch>& matches,
                                        double error_px,
                                        bool use_loops);

/// Looks for the problem's points in images that are paired with those that see them, within
/// `error_px` of where they project: more matches, of which each has one keypoint of the point.
std::vector<KeypointMatch> SearchByProjection(const BundleOptions& options,
                                              const BundleProblem& problem,
                                              const std::vector<std::pair<int, int>>& pairs,
                                              double error_px);

}  // namespace deja_view::internal
