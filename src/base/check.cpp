#include "deja_view/base/check.hpp"

namespace deja_view::internal {

void FailCheck(const char* expression, const char* where) {
  throw CheckError(fmt::format("{}: check failed: {}", where, expression));
}

}  // namespace deja_view::internal
