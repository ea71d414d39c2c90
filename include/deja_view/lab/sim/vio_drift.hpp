#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/lab/sim/flight_path.hpp"
#include "deja_view/lab/sim/options.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::sim {

/// Where a visual-inertial odometry believes the body to be. Yaw walks at random, the scale is off
/// by a little that changes slowly, the velocity has a correlated error; roll and pitch stay within
/// tilt_noise because gravity is observed. The errors are scaled so that the largest position
/// error, with the first poses aligned, is a fraction of the path's length drawn from [drift_min,
/// drift_max]. The odometry's world V has its origin at the first pose and the yaw of W plus a
/// constant.
class VioDrift {
 public:
  VioDrift(const FlightPath& path, const VioOptions& options, std::uint64_t seed);

  /// Estimated T_V_B at t [s], interpolated between steps of 50 ms.
  Rigid3 Pose(double t) const;

  /// T_V_W of the first pose: maps truth to what an odometry without drift would report.
  const Rigid3& T_V_W() const { return T_V_W_; }

  /// The fraction that was drawn.
  double drift() const { return drift_; }

 private:
  struct Noise {
    double yaw_rate = 0;
    double scale = 0;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    Eigen::Vector3d tilt = Eigen::Vector3d::Zero();
  };

  void DrawNoise(const FlightPath& path, const VioOptions& options, std::uint64_t seed);
  /// Fills poses_ with the noise times `amplitude`; returns the largest position error [m].
  double Integrate(const FlightPath& path, double amplitude);

  std::vector<Noise> noise_;  ///< of each step, at amplitude 1
  std::vector<Rigid3> poses_;
  Rigid3 T_V_W_;
  double drift_ = 0;
};

}  // namespace deja_view::sim
