#pragma once

namespace deja_view {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180.0;  ///< in radians

constexpr double ToRadians(double degrees) {
  return degrees * kDegree;
}
constexpr double ToDegrees(double radians) {
  return radians / kDegree;
}

}  // namespace deja_view
