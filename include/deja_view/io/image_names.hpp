#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace deja_view {

/// The stamp [ns] that a file name says, whatever its folder and extension: nanoseconds
/// ("1403636625838560104.png"), or seconds with a point ("1403636625.838560104.png").
std::optional<std::int64_t> ParseImageStamp(std::string_view path);

}  // namespace deja_view
