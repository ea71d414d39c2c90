#include "deja_view/host/world_level.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/host/odometry_check.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace deja_view {
namespace {

// A short turn may have been flown on one side.
constexpr std::int64_t kLeastImages = 100;
// Of the rows' spread across its second direction: the cameras turned by some 65 degrees.
constexpr double kLeastSpread = 0.1;
// An aircraft that turns leans into the turn; a world that is not level is anyhow.
constexpr double kMostTiltDeg = 30;

}  // namespace

void WorldLevel::Add(const Rigid3& T_W_C) {
  if (is_told_) {
    return;
  }
  const Eigen::Vector3d row_W = T_W_C.q * Eigen::Vector3d::UnitX();
  row_spread_W_ += row_W * row_W.transpose();
  down_sum_W_ += T_W_C.q * Eigen::Vector3d(0, 1, 1);
  if (++images_ < kLeastImages) {
    return;
  }
  const auto axis_W = UpFromRowSpread(row_spread_W_ / static_cast<double>(images_), kLeastSpread);
  if (!axis_W) {
    return;
  }
  const Eigen::Vector3d up_W = axis_W->dot(down_sum_W_) > 0 ? -*axis_W : *axis_W;
  if (policy_ == GravityPolicy::kEstimate) {
    T_L_W_.q = Eigen::Quaterniond::FromTwoVectors(up_W, Eigen::Vector3d::UnitZ());
    is_told_ = true;
    return;
  }
  const double tilt_deg = ToDegrees(std::acos(std::clamp(up_W.z(), -1.0, 1.0)));
  if (tilt_deg > kMostTiltDeg) {
    throw UnusableFlight(fmt::format(
        "the odometry's world is tilted by {:.0f} degrees, if the camera is held upright: expected "
        "z up, as of an odometry with an IMU; of one without, its world can be levelled by the "
        "trajectory (gravity: estimate)",
        tilt_deg));
  }
}

std::optional<Rigid3> WorldLevel::T_L_W() const {
  if (policy_ == GravityPolicy::kEstimate && !is_told_) {
    return std::nullopt;
  }
  return T_L_W_;
}

}  // namespace deja_view
