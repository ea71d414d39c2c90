#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace deja_view {

/// Poses over time: poses[i] at stamps_ns[i], which increase strictly.
struct Trajectory {
  std::vector<std::int64_t> stamps_ns;
  std::vector<Rigid3> poses;

  std::size_t size() const { return stamps_ns.size(); }
  bool empty() const { return stamps_ns.empty(); }

  /// Pose at a stamp, interpolated between its neighbours (Interpolate). Nothing before the first
  /// or after the last stamp, nor between neighbours more than `max_gap_ns` apart.
  std::optional<Rigid3> At(
      std::int64_t stamp_ns,
      std::int64_t max_gap_ns = std::numeric_limits<std::int64_t>::max()) const;
};

}  // namespace deja_view
