#pragma once

#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace deja_view {

/// What options must fulfil; collects all violations, so that a user mends them at once:
///   std::vector<std::string> SomeOptions::Validate() const {
///     Requirements r;
///     r.That(radius_m > 0, "radius_m", radius_m, "more than 0");
///     r.Range("levels", levels, 1, 16);
///     r.Group("gate", gate.Validate());
///     return r.errors();
///   }
class Requirements {
 public:
  /// "what", where it can't be said by one key and its value.
  void That(bool holds, std::string what) {
    if (!holds) {
      errors_.push_back(std::move(what));
    }
  }
  /// "key: value, expected expected"
  template <typename T>
  void That(bool holds, const char* key, const T& value, const char* expected) {
    if (!holds) {
      errors_.push_back(fmt::format("{}: {}, expected {}", key, value, expected));
    }
  }
  /// "key: value, expected low to high", also for NaN.
  template <typename T, typename Low, typename High>
  void Range(const char* key, const T& value, const Low& low, const High& high) {
    if (!(value >= low && value <= high)) {
      errors_.push_back(fmt::format("{}: {}, expected {} to {}", key, value, low, high));
    }
  }
  /// The violations of a part, each as "group.violation".
  void Group(const char* group, const std::vector<std::string>& errors) {
    for (const std::string& error : errors) {
      errors_.push_back(fmt::format("{}.{}", group, error));
    }
  }
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  std::vector<std::string> errors_;
};

/// Throws CheckError, or InputError, "what: all violations", if there are any.
void CheckNone(const std::vector<std::string>& violations, const char* what);
void RejectAny(const std::vector<std::string>& violations, const char* what);

}  // namespace deja_view
