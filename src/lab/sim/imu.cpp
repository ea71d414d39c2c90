#include "deja_view/lab/sim/imu.hpp"

#include "deja_view/lab/sim/random.hpp"

#include <cmath>

namespace deja_view::sim {
namespace {

constexpr std::uint64_t kImuStream = 40;

Eigen::Vector3d DrawNormal(Rng* rng) {
  const double x = rng->Normal();
  const double y = rng->Normal();
  return {x, y, rng->Normal()};
}

}  // namespace

std::vector<ImuSample> SimulateImu(const FlightPath& path,
                                   const ImuOptions& options,
                                   std::int64_t start_stamp_ns,
                                   std::uint64_t seed) {
  Rng rng(seed, kImuStream);
  Eigen::Vector3d gyro_bias = options.gyro_bias * DrawNormal(&rng);
  Eigen::Vector3d accel_bias = options.accel_bias * DrawNormal(&rng);
  const double root_rate = std::sqrt(options.rate_hz);
  std::vector<ImuSample> samples;
  const int count = static_cast<int>(std::floor(path.duration() * options.rate_hz)) + 1;
  for (int i = 0; i < count; ++i) {
    const double t = i / options.rate_hz;
    const Eigen::Vector3d force = path.Acceleration(t) + Eigen::Vector3d(0, 0, kGravity);
    ImuSample sample;
    sample.stamp_ns = start_stamp_ns + std::llround(t * 1e9);
    sample.gyro =
        path.AngularVelocity(t) + gyro_bias + options.gyro_noise * root_rate * DrawNormal(&rng);
    sample.accel = path.Pose(t).q.conjugate() * force + accel_bias +
                   options.accel_noise * root_rate * DrawNormal(&rng);
    samples.push_back(sample);
    gyro_bias += options.gyro_bias_walk / root_rate * DrawNormal(&rng);
    accel_bias += options.accel_bias_walk / root_rate * DrawNormal(&rng);
  }
  return samples;
}

}  // namespace deja_view::sim
