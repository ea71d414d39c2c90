#include "deja_view/lab/sim/vio_drift.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/lab/sim/random.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::sim {
namespace {

constexpr double kStep = 0.05;  // [s]
constexpr std::uint64_t kDriftStream = 50;

// Noise at amplitude 1, in proportions as VINS-Mono shows them in halls of this size.
constexpr double kYawRate = 0.0012;  // [rad/s] at 1 m/s
constexpr double kScale = 0.006;     // [-]
constexpr double kVelocity = 0.008;  // [m/s] at 1 m/s

/// First-order Gauss-Markov process with unit standard deviation and time constant `tau` [s].
class Markov {
 public:
  Markov(double tau, Rng* rng) : keep_(std::exp(-kStep / tau)), rng_(rng), value_(rng->Normal()) {}
  double Next() {
    value_ = keep_ * value_ + std::sqrt(1.0 - keep_ * keep_) * rng_->Normal();
    return value_;
  }

 private:
  double keep_;
  Rng* rng_;
  double value_;
};

}  // namespace

VioDrift::VioDrift(const FlightPath& path, const VioOptions& options, std::uint64_t seed) {
  DrawNoise(path, options, seed);
  Rng rng(seed, kDriftStream + 1);
  drift_ = rng.Uniform(options.drift_min, options.drift_max);
  const Rigid3 first = path.Pose(0);
  const Eigen::Quaterniond q_V_W = FromYaw(rng.Uniform(-3.0, 3.0));
  T_V_W_ = {q_V_W, -(q_V_W * first.t)};
  // The error is nearly linear in the amplitude: a few fixed-point steps meet the target.
  const double target = drift_ * path.Length();
  double amplitude = 1.0;
  for (int i = 0; i < 6; ++i) {
    const double error = Integrate(path, amplitude);
    if (error > 0) {
      amplitude *= target / error;
    }
  }
  Integrate(path, amplitude);
}

void VioDrift::DrawNoise(const FlightPath& path, const VioOptions& options, std::uint64_t seed) {
  Rng rng(seed, kDriftStream);
  Markov yaw_rate(4.0, &rng);
  Markov scale(30.0, &rng);
  Markov vx(4.0, &rng);
  Markov vy(4.0, &rng);
  Markov vz(4.0, &rng);
  Markov roll(20.0, &rng);
  Markov pitch(20.0, &rng);
  const double tilt = ToRadians(options.tilt_noise_deg);
  const auto steps = static_cast<std::size_t>(std::ceil(path.duration() / kStep)) + 1;
  for (std::size_t i = 0; i < steps; ++i) {
    // An odometry that does not move does not drift either, or hardly.
    const double speed = path.Velocity(static_cast<double>(i) * kStep).norm();
    const double activity = std::min(1.5, speed) + 0.02;
    Noise noise;
    noise.yaw_rate = kYawRate * activity * yaw_rate.Next();
    noise.scale = kScale * scale.Next();
    const double x = vx.Next();
    const double y = vy.Next();
    noise.velocity = kVelocity * activity * Eigen::Vector3d(x, y, 0.5 * vz.Next());
    const double about_x = roll.Next();
    noise.tilt = tilt * Eigen::Vector3d(about_x, pitch.Next(), 0.0);
    noise_.push_back(noise);
  }
}

double VioDrift::Integrate(const FlightPath& path, double amplitude) {
  poses_.clear();
  double yaw = 0;
  double largest = 0;
  Eigen::Vector3d p_V = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_W = path.Pose(0).t;
  for (std::size_t i = 0; i < noise_.size(); ++i) {
    const Noise& noise = noise_[i];
    const Rigid3 truth = path.Pose(static_cast<double>(i) * kStep);
    const Eigen::Quaterniond q_V_W = FromYaw(yaw) * T_V_W_.q;
    p_V += q_V_W * ((1.0 + amplitude * noise.scale) * (truth.t - last_W)) +
           amplitude * kStep * noise.velocity;
    last_W = truth.t;
    yaw += amplitude * kStep * noise.yaw_rate;
    poses_.push_back({(ExpSo3(noise.tilt) * q_V_W * truth.q).normalized(), p_V});
    largest = std::max(largest, (p_V - T_V_W_ * truth.t).norm());
  }
  return largest;
}

Rigid3 VioDrift::Pose(double t) const {
  const double position = std::clamp(t / kStep, 0.0, static_cast<double>(poses_.size() - 1));
  const auto index = std::min(static_cast<std::size_t>(position), poses_.size() - 2);
  return Interpolate(poses_[index], poses_[index + 1], position - static_cast<double>(index));
}

}  // namespace deja_view::sim
