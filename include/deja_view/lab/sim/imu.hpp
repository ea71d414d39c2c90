#pragma once

#include "deja_view/lab/sim/flight_path.hpp"
#include "deja_view/lab/sim/options.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view::sim {

struct ImuSample {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();  ///< [rad/s] in B
  Eigen::Vector3d accel =
      Eigen::Vector3d::Zero();  ///< specific force [m/s^2] in B: at rest g upwards
};

/// What an IMU at B measures along the whole path: truth, plus a bias that walks, plus white noise.
std::vector<ImuSample> SimulateImu(const FlightPath& path,
                                   const ImuOptions& options,
                                   std::int64_t start_stamp_ns,
                                   std::uint64_t seed);

}  // namespace deja_view::sim
