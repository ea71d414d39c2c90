#include "deja_view/io/seconds.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>

namespace deja_view {
namespace {

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

// digits * 10^exponent; `digits` holds 1 to 40 digits, exponent is at least -80 and at most 40.
struct Decimal {
  std::string digits;
  int exponent = 0;
};

std::optional<Decimal> ParseDecimal(std::string_view text) {
  constexpr int kMaxExponent = 40;
  Decimal decimal;
  std::size_t end = std::min(text.find_first_of("eE"), text.size());
  const std::string_view mantissa = text.substr(0, end);
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  decimal.digits = mantissa.substr(0, point);
  if (point < mantissa.size()) {
    decimal.digits += mantissa.substr(point + 1);
    decimal.exponent = -static_cast<int>(mantissa.size() - point - 1);
  }
  if (decimal.digits.empty() || decimal.digits.size() > 40 ||
      !std::all_of(decimal.digits.begin(), decimal.digits.end(), IsDigit)) {
    return std::nullopt;
  }
  if (end < text.size()) {
    ++end;
    end += text.substr(end, 1) == "+" ? 1 : 0;
    int power = 0;
    const auto result = std::from_chars(text.data() + end, text.data() + text.size(), power);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size() ||
        std::abs(power) > kMaxExponent) {
      return std::nullopt;
    }
    decimal.exponent += power;
  }
  return decimal;
}

}  // namespace

std::optional<std::int64_t> ParseSeconds(std::string_view text) {
  std::optional<Decimal> decimal = ParseDecimal(text);
  if (!decimal) {
    return std::nullopt;
  }
  std::string& digits = decimal->digits;
  const int shift = decimal->exponent + 9;  // to nanoseconds
  bool rounds_up = false;
  if (shift >= 0) {
    digits.append(static_cast<std::size_t>(shift), '0');
  } else {
    const auto cut = static_cast<std::size_t>(-shift);
    digits.insert(0, cut, '0');
    rounds_up = digits[digits.size() - cut] >= '5';
    digits.resize(digits.size() - cut);
  }
  std::int64_t value = 0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ec != std::errc() || value == std::numeric_limits<std::int64_t>::max()) {
    return std::nullopt;
  }
  return value + (rounds_up ? 1 : 0);
}

std::string FormatSeconds(std::int64_t stamp_ns) {
  DEJA_VIEW_CHECK_OP(stamp_ns, >=, 0);
  constexpr std::int64_t kSecond = 1000000000;
  return fmt::format("{}.{:09d}", stamp_ns / kSecond, stamp_ns % kSecond);
}

}  // namespace deja_view
