#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/io/seconds.hpp"

#include <cmath>
#include <cstdint>
#include <string>

namespace deja_view::internal {

/// Appends a pose, its quaternion normalised. Throws InputError that begins with `where` for a
/// quaternion whose norm is off by 1e-3 or a stamp that is not later than the one before.
inline void AppendPose(const std::string& where,
                       std::int64_t stamp_ns,
                       const Rigid3& pose,
                       Trajectory* trajectory) {
  if (!(std::abs(pose.q.norm() - 1.0) < 1e-3)) {
    ThrowInputError(
        "{}: expected a unit quaternion, found one of norm {:.6g}", where, pose.q.norm());
  }
  if (!trajectory->empty() && stamp_ns <= trajectory->stamps_ns.back()) {
    ThrowInputError("{}: expected a stamp later than {}, found {}",
                    where,
                    FormatSeconds(trajectory->stamps_ns.back()),
                    FormatSeconds(stamp_ns));
  }
  trajectory->stamps_ns.push_back(stamp_ns);
  trajectory->poses.push_back({pose.q.normalized(), pose.t});
}

}  // namespace deja_view::internal
