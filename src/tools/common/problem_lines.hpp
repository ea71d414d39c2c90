#pragma once

#include <string>
#include <vector>

namespace deja_view {

/// A line for each kind of problem, in the order of their first ones: the first one's words, with
/// how many more there are that differ in their stamps (nanoseconds) alone.
std::vector<std::string> ProblemLines(const std::vector<std::string>& problems);

}  // namespace deja_view
