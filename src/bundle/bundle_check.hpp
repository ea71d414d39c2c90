#pragma once

#include "deja_view/bundle/bundle_problem.hpp"

#include <string>
#include <vector>

namespace deja_view::internal {

/// Throws CheckError for indices, sizes and values that make no problem.
void CheckProblem(const BundleProblem& problem);

/// Says that priors and these points leave the images in pieces that could move against each
/// other; empty when they do not.
std::string FindGap(const BundleProblem& problem, const std::vector<int>& points);

}  // namespace deja_view::internal
