#include "deja_view/base/requirements.hpp"

#include "deja_view/base/check.hpp"

namespace deja_view {

void CheckNone(const std::vector<std::string>& violations, const char* what) {
  if (!violations.empty()) {
    throw CheckError(fmt::format("{}: {}", what, fmt::join(violations, "; ")));
  }
}

void RejectAny(const std::vector<std::string>& violations, const char* what) {
  if (!violations.empty()) {
    ThrowInputError("{}: {}", what, fmt::join(violations, "; "));
  }
}

}  // namespace deja_view
