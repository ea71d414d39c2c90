#include "deja_view/geometry/trajectory.hpp"

#include <algorithm>

namespace deja_view {

std::optional<Rigid3> Trajectory::At(std::int64_t stamp_ns, std::int64_t max_gap_ns) const {
  const auto next = std::lower_bound(stamps_ns.begin(), stamps_ns.end(), stamp_ns);
  if (next == stamps_ns.end()) {
    return std::nullopt;
  }
  const std::ptrdiff_t i = next - stamps_ns.begin();
  if (*next == stamp_ns) {
    return poses[i];
  }
  if (i == 0 || *next - *(next - 1) > max_gap_ns) {
    return std::nullopt;
  }
  const double u = static_cast<double>(stamp_ns - stamps_ns[i - 1]) /
                   static_cast<double>(stamps_ns[i] - stamps_ns[i - 1]);
  return Interpolate(poses[i - 1], poses[i], u);
}

}  // namespace deja_view
