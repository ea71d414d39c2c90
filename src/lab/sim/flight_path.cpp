#include "deja_view/lab/sim/flight_path.hpp"

#include <cmath>

#include "flight_planner.hpp"

namespace deja_view::sim {
namespace {

/// Body on the vehicle F (x ahead, y left, z up along the thrust): x up, y right, z ahead and 10
/// deg down.
Eigen::Quaterniond VehicleToBody() {
  Eigen::Matrix3d R_F_B;
  R_F_B << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  return ExpSo3({0, 0.17, 0}) * Eigen::Quaterniond(R_F_B);
}

}  // namespace

FlightPath::FlightPath(const World& world, const FlightOptions& options, std::uint64_t seed)
    : options_(options), spline_(FlightPlanner(world, options, seed).Plan()) {}

Rigid3 FlightPath::Pose(double t) const {
  const QuinticSpline::Value value = spline_.Evaluate(t, 0);
  const Eigen::Vector3d up = (Acceleration(t) + Eigen::Vector3d(0, 0, kGravity)).normalized();
  const Eigen::Vector3d heading(std::cos(value[3]), std::sin(value[3]), 0);
  Eigen::Matrix3d R_W_F;
  R_W_F.col(2) = up;
  R_W_F.col(1) = up.cross(heading).normalized();
  R_W_F.col(0) = R_W_F.col(1).cross(up);
  return {(Eigen::Quaterniond(R_W_F) * VehicleToBody()).normalized(), value.head<3>()};
}

Eigen::Vector3d FlightPath::Velocity(double t) const {
  return spline_.Evaluate(t, 1).head<3>();
}

Eigen::Vector3d FlightPath::Acceleration(double t) const {
  return spline_.Evaluate(t, 2).head<3>();
}

Eigen::Vector3d FlightPath::AngularVelocity(double t) const {
  constexpr double kDelta = 5e-4;  // [s]; the error of the central difference is of order kDelta^2
  const Eigen::Quaterniond before = Pose(t - kDelta).q;
  const Eigen::Quaterniond after = Pose(t + kDelta).q;
  const double low = std::max(0.0, t - kDelta);
  const double high = std::min(spline_.duration(), t + kDelta);
  return LogSo3(before.conjugate() * after) / (high - low);
}

double FlightPath::Length() const {
  constexpr double kDelta = 0.01;
  double length = 0;
  for (int i = 0; i * kDelta < duration(); ++i) {
    length += kDelta * Velocity((i + 0.5) * kDelta).norm();
  }
  return length;
}

Trajectory FlightPath::GroundTruth(std::int64_t start_stamp_ns) const {
  Trajectory poses;
  const int count = static_cast<int>(std::floor(duration() * options_.ground_truth_rate_hz)) + 1;
  for (int i = 0; i < count; ++i) {
    const double t = i / options_.ground_truth_rate_hz;
    poses.stamps_ns.push_back(start_stamp_ns + std::llround(t * 1e9));
    poses.poses.push_back(Pose(t));
  }
  return poses;
}

}  // namespace deja_view::sim
