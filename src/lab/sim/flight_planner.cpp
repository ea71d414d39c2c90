#include "flight_planner.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view::sim {
namespace {

constexpr double kTwoPi = 2 * kPi;
constexpr double kStep = 0.5;       // [s] between knots
constexpr double kRamp = 1.5;       // [s] to speed up and to slow down
constexpr double kMostSpeed = 1.6;  // momentary over mean
constexpr std::uint64_t kPlannerStream = 30;

double SmoothStep(double x) {
  const double c = std::clamp(x, 0.0, 1.0);
  return c * c * (3.0 - 2.0 * c);
}

}  // namespace

double FlightPlanner::Wave::At(double angle) const {
  double sum = 0;
  for (int i = 0; i < kHarmonics; ++i) {
    sum += sine[i] * std::sin((i + 1) * angle) + cosine[i] * std::cos((i + 1) * angle);
  }
  return sum;
}

FlightPlanner::FlightPlanner(const World& world, const FlightOptions& options, std::uint64_t seed)
    : world_(world), options_(options), rng_(seed, kPlannerStream) {
  const double room = 0.5 * std::min(world.size().x(), world.size().y());
  wave_aside_ = DrawWave(0.07 * room);
  wave_up_ = DrawWave(0.2);
  wave_turn_ = DrawWave(0.35);
  wave_speed_ = DrawWave(0.3);
  start_angle_ = rng_.Uniform(0, kTwoPi);
  direction_ = rng_.Chance(0.5) ? 1.0 : -1.0;
  DrawLaps();
}

FlightPlanner::Wave FlightPlanner::DrawWave(double amplitude) {
  Wave wave;
  for (int i = 0; i < kHarmonics; ++i) {
    wave.sine[i] = amplitude * rng_.Uniform(-1, 1) / (i + 1);
    wave.cosine[i] = amplitude * rng_.Uniform(-1, 1) / (i + 1);
  }
  return wave;
}

void FlightPlanner::DrawLaps() {
  const double room = 0.5 * std::min(world_.size().x(), world_.size().y());
  laps_.resize(1000);
  for (std::size_t i = 1; i < laps_.size(); ++i) {
    const bool same = i % 2 == 1;
    Lap& lap = laps_[i];
    lap.aside = same ? rng_.Uniform(-0.15, 0.15) : rng_.Uniform(0.06, 0.13) * room;
    lap.up = same ? rng_.Uniform(-0.1, 0.1) : rng_.Uniform(0.2, 0.5);
    lap.turn = same ? rng_.Uniform(-0.08, 0.08) : rng_.Uniform(0.3, 0.6);
    if (!same) {
      lap.aside *= rng_.Chance(0.5) ? 1.0 : -1.0;
      lap.up *= rng_.Chance(0.5) ? 1.0 : -1.0;
      lap.turn *= rng_.Chance(0.5) ? 1.0 : -1.0;
    }
  }
}

/// `angle` counts on over all laps; the last sixth of a lap leads over to the next one.
FlightPlanner::Lap FlightPlanner::LapAt(double angle) const {
  const double turns = std::abs(angle - start_angle_) / kTwoPi;
  const auto index = std::min(static_cast<std::size_t>(turns), laps_.size() - 2);
  const double blend = SmoothStep((turns - static_cast<double>(index) - 5.0 / 6.0) * 6.0);
  const Lap& from = laps_[index];
  const Lap& to = laps_[index + 1];
  return {from.aside + blend * (to.aside - from.aside),
          from.up + blend * (to.up - from.up),
          from.turn + blend * (to.turn - from.turn)};
}

Eigen::Vector3d FlightPlanner::PointAt(double angle, const Lap& lap) const {
  const Eigen::Vector3d half = 0.5 * world_.size();
  const double aside = wave_aside_.At(angle) + lap.aside;
  const double height = std::min(0.36 * world_.size().z(), 1.6) + wave_up_.At(angle) + lap.up;
  return {half.x() + (0.58 * half.x() + aside) * std::cos(angle),
          half.y() + (0.58 * half.y() + aside) * std::sin(angle),
          std::clamp(height, 0.9, world_.size().z() - 1.0)};
}

double FlightPlanner::HeadingAt(double angle) const {
  const Eigen::Vector3d ahead =
      direction_ * (PointAt(angle + 0.02, Lap()) - PointAt(angle - 0.02, Lap()));
  return std::atan2(ahead.y(), ahead.x());
}

double FlightPlanner::SpeedAt(double t) const {
  const double begin = SmoothStep((t - options_.hover_s) / kRamp);
  const double end = SmoothStep((options_.duration_s - t) / kRamp);
  const double wave = 1.0 + wave_speed_.At(kTwoPi * t / 25.0);
  return std::clamp(wave, 0.5, 1.5) * begin * end;
}

std::vector<QuinticSpline::Value> FlightPlanner::ControlPoints(double speed, double wander) const {
  std::vector<QuinticSpline::Value> points;
  double angle = start_angle_;
  double heading = HeadingAt(angle);
  // A point acts up to three knots before and after its own time.
  const int count = static_cast<int>(std::ceil(options_.duration_s / kStep)) + 6;
  for (int i = 0; i < count; ++i) {
    const Lap lap = LapAt(angle);
    const Eigen::Vector3d p = PointAt(angle, lap);
    heading += WrapAngle(HeadingAt(angle) - heading);
    // Looks outwards a little, where the hall's walls are.
    const double outwards = -0.25 * direction_;
    const double yaw = heading + outwards + wander * (wave_turn_.At(angle) + lap.turn);
    points.emplace_back(p.x(), p.y(), p.z(), yaw);
    const double advance = speed * SpeedAt((i - 2) * kStep) * kStep;
    const double per_radian =
        (PointAt(angle + 0.01, lap) - PointAt(angle - 0.01, lap)).norm() / 0.02;
    angle += direction_ * advance / per_radian;
  }
  return points;
}

/// Step [m] away from what is nearer than `clearance`, along the gradient of the clearance; 0 where
/// there is room.
Eigen::Vector3d FlightPlanner::Escape(const Eigen::Vector3d& p, double clearance) const {
  constexpr double kDelta = 1e-3;
  const double missing = clearance - world_.Clearance(p);
  if (missing <= 0) {
    return Eigen::Vector3d::Zero();
  }
  Eigen::Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d delta = kDelta * Eigen::Vector3d::Unit(axis);
    gradient[axis] = world_.Clearance(p + delta) - world_.Clearance(p - delta);
  }
  return (0.6 * missing + 0.01) * gradient.normalized();
}

/// Bends the path around what is too near. The displacements are smoothed along the path in every
/// round, so that the flight swerves in time instead of jerking aside.
void FlightPlanner::PushAway(double clearance, std::vector<QuinticSpline::Value>* points) const {
  const std::vector<QuinticSpline::Value> planned = *points;
  const std::size_t count = points->size();
  std::vector<Eigen::Vector3d> aside(count, Eigen::Vector3d::Zero());
  for (int round = 0; round < 60; ++round) {
    bool moved = false;
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d step = Escape(planned[i].head<3>() + aside[i], clearance);
      moved |= step.squaredNorm() > 0;
      aside[i] += step;
    }
    if (!moved) {
      break;
    }
    std::vector<Eigen::Vector3d> smooth = aside;
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d& before = aside[i > 0 ? i - 1 : 0];
      const Eigen::Vector3d& after = aside[std::min(i + 1, count - 1)];
      smooth[i] = 0.5 * aside[i] + 0.25 * (before + after);
    }
    aside = smooth;
  }
  for (std::size_t i = 0; i < count; ++i) {
    (*points)[i].head<3>() += aside[i];
  }
}

double FlightPlanner::LeastClearance(const QuinticSpline& spline) const {
  double least = 1e9;
  for (double t = 0; t <= options_.duration_s; t += 0.05) {
    least = std::min(least, world_.Clearance(spline.Evaluate(t, 0).head<3>()));
  }
  return least;
}

double FlightPlanner::LargestSpeed(const QuinticSpline& spline) const {
  double largest = 0;
  for (double t = 0; t <= options_.duration_s; t += 0.05) {
    largest = std::max(largest, spline.Evaluate(t, 1).head<3>().norm());
  }
  return largest;
}

double FlightPlanner::LargestYawRate(const QuinticSpline& spline) const {
  double largest = 0;
  for (double t = 0; t <= options_.duration_s; t += 0.05) {
    largest = std::max(largest, std::abs(spline.Evaluate(t, 1)[3]));
  }
  return largest;
}

QuinticSpline FlightPlanner::Plan() {
  const double max_yaw_rate = options_.max_yaw_rate_deg_s * kTwoPi / 360.0;
  double speed = options_.mean_speed_m_s;
  double wander = 1.0;
  double margin = 0.1;
  for (int attempt = 0; attempt < 60; ++attempt) {
    auto points = ControlPoints(speed, wander);
    PushAway(options_.clearance_m + margin, &points);
    const QuinticSpline spline(std::move(points), kStep);
    if (LeastClearance(spline) < options_.clearance_m) {
      margin += 0.05;
    } else if (LargestYawRate(spline) > max_yaw_rate) {
      wander *= 0.85;
      speed *= 0.98;
    } else if (LargestSpeed(spline) > kMostSpeed * options_.mean_speed_m_s) {
      speed *= 0.95;
    } else {
      return spline;
    }
  }
  ThrowInputError("flight.clearance_m: no way through the hall keeps {} m from everything",
                  options_.clearance_m);
}

}  // namespace deja_view::sim
