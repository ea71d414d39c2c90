#pragma once

#include "deja_view/base/check.hpp"

#include <string>
#include <vector>

namespace deja_view::internal {

/// Throws CheckError that lists the violations, if there are any.
inline void CheckValid(const std::vector<std::string>& violations) {
  if (!violations.empty()) {
    throw CheckError(fmt::format("options: {}", fmt::join(violations, "; ")));
  }
}

}  // namespace deja_view::internal
