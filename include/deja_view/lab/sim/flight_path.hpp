#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/spline.hpp"
#include "deja_view/lab/sim/world.hpp"

#include <cstdint>

namespace deja_view::sim {

inline constexpr double kGravity = 9.81;  ///< [m/s^2], along -z of W

/// A smooth drone flight: laps around the hall. The second lap repeats the first nearly (revisits
/// from the same viewpoint), the third passes the same places from aside, higher or lower and
/// looking elsewhere, and so on. Tilt follows from acceleration, as for a multicopter. Times are
/// seconds from the start.
class FlightPath {
 public:
  /// Throws InputError when no way through the hall keeps `options.clearance_m`.
  FlightPath(const World& world, const FlightOptions& options, std::uint64_t seed);

  double duration() const { return options_.duration_s; }

  Rigid3 Pose(double t) const;                      ///< T_W_B
  Eigen::Vector3d Velocity(double t) const;         ///< of B in W [m/s]
  Eigen::Vector3d Acceleration(double t) const;     ///< of B in W [m/s^2]
  Eigen::Vector3d AngularVelocity(double t) const;  ///< of B against W, in B [rad/s]
  double Length() const;                            ///< [m]

  /// Poses at `options.ground_truth_rate_hz`, beginning with t = 0.
  Trajectory GroundTruth(std::int64_t start_stamp_ns) const;

 private:
  FlightOptions options_;
  QuinticSpline spline_;
};

}  // namespace deja_view::sim
