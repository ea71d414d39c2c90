#pragma once

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <string>

namespace deja_view::internal {

/// Throws InputError for a name that could lead out of its directory: `kind` says what it is of, as
/// "map".
inline void CheckName(const std::string& kind, const std::string& name) {
  constexpr std::size_t kMaxLength = 128;
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  const auto is_forbidden = [&](unsigned char c) { return is_control(c) || c == '/' || c == '\\'; };
  if (name.empty() || name.size() > kMaxLength || name.front() == '.' ||
      std::any_of(name.begin(), name.end(), is_forbidden)) {
    std::string printable = name.substr(0, kMaxLength);
    std::replace_if(printable.begin(), printable.end(), is_control, '?');
    ThrowInputError(
        "{} name '{}': expected 1 to {} bytes without '/', '\\' and control characters, not "
        "starting with '.'",
        kind,
        printable,
        kMaxLength);
  }
}

}  // namespace deja_view::internal
