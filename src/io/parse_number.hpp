#pragma once

#include <cmath>
#include <locale>
#include <optional>
#include <sstream>
#include <string>

namespace deja_view::internal {

/// A finite decimal number that is all of `text`, whatever the process' locale; hexadecimal, "inf"
/// and "nan" are refused. (std::from_chars reads integers only in older standard libraries.)
template <typename T>
std::optional<T> ParseNumber(const std::string& text) {
  if (text.find_first_not_of("0123456789+-.eE") != std::string::npos) {
    return std::nullopt;
  }
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  T value{};
  stream >> value;
  const bool is_number = !stream.fail() && stream.peek() == std::istringstream::traits_type::eof();
  return is_number && std::isfinite(value) ? std::make_optional(value) : std::nullopt;
}

}  // namespace deja_view::internal
