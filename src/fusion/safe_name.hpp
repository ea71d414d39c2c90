#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"

#include <algorithm>
#include <string>
#include <string_view>

namespace deja_view::internal {

/// Throws InputError for a name that could lead out of its directory, or be taken for something
/// else by a shell or program: `kind` says what it is of, as "map".
inline void CheckName(const std::string& kind, const std::string& name) {
  constexpr std::size_t kMaxLength = 128;
  static constexpr std::string_view kOthers = " _-.+(),";
  static constexpr std::string_view kNotFirst = " -.";
  const auto is_allowed = [](unsigned char c) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c >= 0x80;
    return is_letter || (c >= '0' && c <= '9') ||
           kOthers.find(static_cast<char>(c)) != kOthers.npos;
  };
  if (name.empty() || name.size() > kMaxLength || kNotFirst.find(name.front()) != kNotFirst.npos ||
      !std::all_of(name.begin(), name.end(), is_allowed)) {
    ThrowInputError(
        "{} name {}: expected 1 to {} bytes of letters, digits, spaces and _ - . + ( ) and commas, "
        "not starting with a space, '-' or '.'",
        kind,
        Quote(name),
        kMaxLength);
  }
}

}  // namespace deja_view::internal
