#pragma once

#include "deja_view/bundle/bundle_problem.hpp"

#include <vector>

namespace deja_view::internal {

/// Indices of points, ascending, such that every image keeps about `per_image` observations where
/// it has so many, spread over the image; points that many images see come first. 0: all points.
std::vector<int> SelectPoints(const BundleProblem& problem, int per_image);

}  // namespace deja_view::internal
