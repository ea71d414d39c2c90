#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace deja_view {

/// Names of an enum's values, for config files and messages: those of 0, 1, 2 ... in this order.
/// Specialise it beside the enum:
///   template <>
///   inline constexpr auto kEnumNames<Kind> = EnumNames("brief", "orb");
template <typename Enum>
inline constexpr auto kEnumNames = nullptr;

template <typename... Text>
constexpr std::array<std::string_view, sizeof...(Text)> EnumNames(Text... names) {
  return {names...};
}

/// Name of `value`; "?" for a value without one.
template <typename Enum>
std::string EnumToString(Enum value) {
  const auto i = static_cast<std::size_t>(value);
  return std::string(i < kEnumNames<Enum>.size() ? kEnumNames<Enum>[i] : "?");
}

template <typename Enum>
std::optional<Enum> EnumFromString(std::string_view text) {
  for (std::size_t i = 0; i < kEnumNames<Enum>.size(); ++i) {
    if (text == kEnumNames<Enum>[i]) {
      return static_cast<Enum>(i);
    }
  }
  return std::nullopt;
}

/// "brief, orb": all names, for error messages.
template <typename Enum>
std::string EnumNameList() {
  std::string list;
  for (const std::string_view name : kEnumNames<Enum>) {
    list += (list.empty() ? "" : ", ") + std::string(name);
  }
  return list;
}

}  // namespace deja_view
