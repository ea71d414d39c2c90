#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace deja_view {

/// Seconds as decimal text, with or without exponent, to nanoseconds by integer arithmetic; rounded
/// to the nearest. Nothing for other text, negative values and values beyond the range of int64.
std::optional<std::int64_t> ParseSeconds(std::string_view text);

/// "1403636625.838560104".
std::string FormatSeconds(std::int64_t stamp_ns);

}  // namespace deja_view
