#include "deja_view/io/image_names.hpp"

#include "deja_view/io/seconds.hpp"

#include <algorithm>
#include <charconv>

namespace deja_view {

std::optional<std::int64_t> ParseImageStamp(std::string_view path) {
  std::string_view stem = path.substr(path.find_last_of('/') + 1);
  stem = stem.substr(0, stem.find_last_of('.'));
  if (stem.find('.') != std::string_view::npos) {
    const bool is_decimal = stem.find_first_not_of("0123456789.") == std::string_view::npos;
    return is_decimal ? ParseSeconds(stem) : std::nullopt;
  }
  std::int64_t stamp_ns = 0;
  const char* end = stem.data() + stem.size();
  const auto result = std::from_chars(stem.data(), end, stamp_ns);
  if (result.ec != std::errc() || result.ptr != end || stamp_ns < 0) {
    return std::nullopt;
  }
  return stamp_ns;
}

}  // namespace deja_view
