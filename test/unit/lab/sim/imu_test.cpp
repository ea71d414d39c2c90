#include "deja_view/lab/sim/imu.hpp"

#include <cmath>

#include "small_world.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

ImuOptions IdealImu() {
  ImuOptions options;
  options.gyro_noise = options.accel_noise = options.gyro_bias = options.accel_bias = 0;
  options.gyro_bias_walk = options.accel_bias_walk = 0;
  return options;
}

TEST(SimulateImu, IntegratesToThePath) {
  const FlightPath path(*TinyWorld(), TinyOptions().flight, 1);
  const auto samples = SimulateImu(path, IdealImu(), 0, 1);
  Rigid3 pose = path.Pose(0);
  Eigen::Vector3d velocity = path.Velocity(0);
  const Eigen::Vector3d gravity(0, 0, kGravity);
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const double dt = 1e-9 * static_cast<double>(samples[i + 1].stamp_ns - samples[i].stamp_ns);
    const Eigen::Vector3d gyro = 0.5 * (samples[i].gyro + samples[i + 1].gyro);
    const Eigen::Quaterniond next = pose.q * ExpSo3(dt * gyro);
    const Eigen::Vector3d acceleration =
        0.5 * (pose.q * samples[i].accel + next * samples[i + 1].accel) - gravity;
    pose.t += dt * velocity + 0.5 * dt * dt * acceleration;
    velocity += dt * acceleration;
    pose.q = next;
  }
  const Rigid3 end = path.Pose(path.duration());
  EXPECT_LT((pose.t - end.t).norm(), 1e-3);
  EXPECT_LT(RotationAngle(pose.q.conjugate() * end.q), 1e-4);
}

TEST(SimulateImu, MeasuresGravityUpwardsAtRest) {
  const FlightPath path(*TinyWorld(), TinyOptions().flight, 1);
  const auto samples = SimulateImu(path, IdealImu(), 0, 1);
  EXPECT_NEAR(samples[0].accel.norm(), kGravity, 1e-9);
  EXPECT_GT(samples[0].accel.x(), 9.5);  // the body's x axis points up
  EXPECT_LT(samples[0].gyro.norm(), 1e-9);
}

TEST(SimulateImu, NoiseAndBiasHaveTheAskedSize) {
  const FlightPath path(*TinyWorld(), TinyOptions().flight, 1);
  ImuOptions options = IdealImu();
  options.gyro_noise = 1e-3;
  options.accel_bias = 0.1;
  const auto truth = SimulateImu(path, IdealImu(), 0, 1);
  const auto samples = SimulateImu(path, options, 0, 1);
  double sum = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    sum += (samples[i].gyro - truth[i].gyro).squaredNorm();
  }
  const double sigma = std::sqrt(sum / (3.0 * static_cast<double>(samples.size())));
  EXPECT_NEAR(sigma, 1e-3 * std::sqrt(200.0), 1e-3);
  const Eigen::Vector3d bias = samples[0].accel - truth[0].accel;
  EXPECT_GT(bias.norm(), 0.01);
  EXPECT_LT((samples.back().accel - truth.back().accel - bias).norm(), 1e-9);
}

}  // namespace
}  // namespace deja_view::sim
