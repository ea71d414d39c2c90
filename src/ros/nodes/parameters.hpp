#pragma once

#include "deja_view/base/check.hpp"

#include <string>

#include <ros/node_handle.h>

namespace deja_view::internal {

/// A parameter, or `fallback` where there is none. Throws InputError that names it when it is of
/// another type; `type` says what was expected.
template <typename T>
T ReadParameter(const ros::NodeHandle& handle,
                const std::string& name,
                const T& fallback,
                const char* type) {
  T value = fallback;
  if (handle.hasParam(name) && !handle.getParam(name, value)) {
    ThrowInputError("parameter {}: expected {}", handle.resolveName(name), type);
  }
  return value;
}

inline std::string ReadText(const ros::NodeHandle& handle,
                            const std::string& name,
                            const std::string& fallback = {}) {
  return ReadParameter<std::string>(handle, name, fallback, "text");
}

/// Throws InputError when it is missing or empty; `expected` says what it names.
inline std::string ReadRequired(const ros::NodeHandle& handle,
                                const std::string& name,
                                const char* expected = "a file") {
  std::string value = ReadText(handle, name);
  if (value.empty()) {
    ThrowInputError("parameter {} is missing: expected {}", handle.resolveName(name), expected);
  }
  return value;
}

}  // namespace deja_view::internal
