#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace deja_view {

/// Names of an enum's values, for config files and messages. Specialise it beside the enum:
///   template <> struct EnumNames<Kind> {
///     static constexpr std::array<std::pair<Kind, const char*>, 2> kNames = {
///         {{Kind::kBrief, "brief"}, {Kind::kOrb, "orb"}}};
///   };
template <typename Enum>
struct EnumNames;

/// Name of `value`; "?" for a value without one.
template <typename Enum>
std::string EnumToString(Enum value) {
  for (const auto& [candidate, name] : EnumNames<Enum>::kNames) {
    if (candidate == value) {
      return name;
    }
  }
  return "?";
}

template <typename Enum>
std::optional<Enum> EnumFromString(std::string_view text) {
  for (const auto& [value, name] : EnumNames<Enum>::kNames) {
    if (text == name) {
      return value;
    }
  }
  return std::nullopt;
}

/// "brief, orb": all names, for error messages.
template <typename Enum>
std::string EnumNameList() {
  std::string list;
  for (const auto& entry : EnumNames<Enum>::kNames) {
    list += (list.empty() ? "" : ", ") + std::string(entry.second);
  }
  return list;
}

}  // namespace deja_view
