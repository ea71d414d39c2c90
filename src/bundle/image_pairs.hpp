#pragma once

#include "deja_view/bundle/bundle_options.hpp"
#include "deja_view/bundle/bundle_problem.hpp"

#include <utility>
#include <vector>

namespace deja_view::internal {

/// Pairs (older, newer) of images that may show the same things, ascending: neighbours in time,
/// loops, and for each image older ones that look the same way from nearby, chosen in turn from
/// each of the earlier visits so that the newest does not take all places.
std::vector<std::pair<int, int>> ChooseImagePairs(const BundleOptions& options,
                                                  const BundleProblem& problem);

}  // namespace deja_view::internal
