#pragma once

#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/random.hpp"
#include "deja_view/lab/sim/spline.hpp"
#include "deja_view/lab/sim/world.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace deja_view::sim {

/// Lays out the control points of a flight. See FlightPath.
class FlightPlanner {
 public:
  FlightPlanner(const World& world, const FlightOptions& options, std::uint64_t seed);

  /// Throws InputError when the hall leaves no room.
  QuinticSpline Plan();

 private:
  static constexpr int kHarmonics = 3;
  /// How a lap differs from the first.
  struct Lap {
    double aside = 0;  ///< [m] outwards
    double up = 0;     ///< [m]
    double turn = 0;   ///< [rad]
  };
  /// A periodic function of the angle around the hall.
  struct Wave {
    std::array<double, kHarmonics> sine{}, cosine{};
    double At(double angle) const;
  };

  Wave DrawWave(double amplitude);
  void DrawLaps();
  Lap LapAt(double angle) const;
  Eigen::Vector3d PointAt(double angle, const Lap& lap) const;
  double HeadingAt(double angle) const;
  double SpeedAt(double t) const;
  std::vector<QuinticSpline::Value> ControlPoints(double speed, double wander) const;
  Eigen::Vector3d Escape(const Eigen::Vector3d& p, double clearance) const;
  void PushAway(double clearance, std::vector<QuinticSpline::Value>* points) const;
  double LeastClearance(const QuinticSpline& spline) const;
  double LargestSpeed(const QuinticSpline& spline) const;
  double LargestYawRate(const QuinticSpline& spline) const;

  const World& world_;
  FlightOptions options_;
  Rng rng_;
  std::vector<Lap> laps_;
  Wave wave_aside_, wave_up_, wave_turn_, wave_speed_;
  double start_angle_ = 0;
  double direction_ = 1;
};

}  // namespace deja_view::sim
