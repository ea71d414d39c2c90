#include "deja_view/lab/sim/options.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

#include <fmt/format.h>

namespace deja_view::sim {
namespace {

/// Collects violations; a NaN is one too.
class Violations {
 public:
  template <typename T>
  void Range(const char* key, T value, double low, double high) {
    const auto number = static_cast<double>(value);
    if (!(number >= low && number <= high)) {
      list_.push_back(fmt::format("{}: {} is not in [{}, {}]", key, value, low, high));
    }
  }
  void Require(bool condition, std::string text) {
    if (!condition) {
      list_.push_back(std::move(text));
    }
  }
  std::vector<std::string> list() const { return list_; }

 private:
  std::vector<std::string> list_;
};

void CheckWorld(const WorldOptions& o, Violations* v) {
  v->Range("world.length_m", o.length_m, 6.0, 60.0);
  v->Range("world.width_m", o.width_m, 6.0, 60.0);
  v->Range("world.height_m", o.height_m, 2.8, 15.0);
  v->Range("world.texture_strength", o.texture_strength, 0.0, 1.5);
  v->Range("world.repetition", o.repetition, 0.0, 1.0);
  v->Range("world.windows", o.windows, 0, 40);
  v->Range("world.window_radiance", o.window_radiance, 0.1, 100.0);
  v->Range("world.furniture", o.furniture, 0, 500);
  v->Range("world.posters", o.posters, 0, 500);
  v->Range("world.texture_size_px", o.texture_size_px, 64, 2048);
  v->Require((o.texture_size_px & (o.texture_size_px - 1)) == 0,
             fmt::format("world.texture_size_px: {} is not a power of two", o.texture_size_px));
  v->Range("world.light_spacing_m", o.light_spacing_m, 0.05, 2.0);
}

void CheckFlight(const FlightOptions& o, Violations* v) {
  v->Range("flight.duration_s", o.duration_s, 2.0, 3600.0);
  v->Range("flight.mean_speed_m_s", o.mean_speed_m_s, 0.2, 1.5);
  v->Range("flight.max_yaw_rate_deg_s", o.max_yaw_rate_deg_s, 20.0, 180.0);
  v->Range("flight.clearance_m", o.clearance_m, 0.1, 0.6);
  v->Range("flight.hover_s", o.hover_s, 0.0, 60.0);
  v->Range("flight.ground_truth_rate_hz", o.ground_truth_rate_hz, 10.0, 1000.0);
}

void CheckSensor(const SensorOptions& o, Violations* v) {
  v->Range("sensor.image_rate_hz", o.image_rate_hz, 1.0, 60.0);
  v->Range("sensor.exposure_ms", o.exposure_ms, 0.0, 100.0);
  v->Require(
      o.exposure_ms * o.image_rate_hz <= 1000.0,
      fmt::format("sensor.exposure_ms: {} is longer than the time between images", o.exposure_ms));
  v->Range("sensor.samples", o.samples, 1, 64);
  v->Range("sensor.target_level", o.target_level, 0.01, 0.9);
  v->Range("sensor.exposure_adaption", o.exposure_adaption, 0.0, 1.0);
  v->Range("sensor.vignetting", o.vignetting, 0.0, 2.0);
  v->Range("sensor.noise", o.noise, 0.0, 30.0);
  v->Range("sensor.gamma", o.gamma, 1.0, 3.0);
}

void CheckImu(const ImuOptions& o, Violations* v) {
  v->Range("imu.rate_hz", o.rate_hz, 20.0, 1000.0);
  v->Range("imu.gyro_noise", o.gyro_noise, 0.0, 1.0);
  v->Range("imu.accel_noise", o.accel_noise, 0.0, 1.0);
  v->Range("imu.gyro_bias", o.gyro_bias, 0.0, 1.0);
  v->Range("imu.accel_bias", o.accel_bias, 0.0, 5.0);
  v->Range("imu.gyro_bias_walk", o.gyro_bias_walk, 0.0, 1.0);
  v->Range("imu.accel_bias_walk", o.accel_bias_walk, 0.0, 1.0);
}

void CheckVio(const VioOptions& o, Violations* v) {
  v->Range("vio.max_points", o.max_points, 10, 1000);
  v->Range("vio.min_distance_px", o.min_distance_px, 2.0, 100.0);
  v->Range("vio.pixel_noise_px", o.pixel_noise_px, 0.0, 5.0);
  v->Range("vio.outlier_fraction", o.outlier_fraction, 0.0, 0.9);
  v->Range("vio.keyframe_parallax_px", o.keyframe_parallax_px, 0.0, 200.0);
  v->Range("vio.drift_min", o.drift_min, 0.0, 0.2);
  v->Range("vio.drift_max", o.drift_max, 0.0, 0.2);
  v->Require(o.drift_min <= o.drift_max,
             fmt::format("vio.drift_min: {} is above drift_max {}", o.drift_min, o.drift_max));
  v->Range("vio.tilt_noise_deg", o.tilt_noise_deg, 0.0, 5.0);
  v->Range("vio.keyframe_delay_s", o.keyframe_delay_s, 0.0, 2.0);
  v->Range("vio.odometry_delay_s", o.odometry_delay_s, 0.0, 2.0);
}

}  // namespace

std::vector<std::string> SimOptions::Validate() const {
  Violations violations;
  violations.Range("threads", threads, 0, 1024);
  violations.Require(start_stamp_ns >= 0 && start_stamp_ns < 4000000000LL * 1000000000LL,
                     fmt::format("start_stamp_ns: {} does not fit a ROS stamp", start_stamp_ns));
  CheckWorld(world, &violations);
  CheckFlight(flight, &violations);
  violations.Range("camera.scale", camera.scale, 0.1, 2.0);
  CheckSensor(sensor, &violations);
  CheckImu(imu, &violations);
  CheckVio(vio, &violations);
  return violations.list();
}

std::vector<std::string> PresetNames() {
  return {"hall", "weak_texture", "repeated", "windows", "blur", "small"};
}

SimOptions MakePreset(const std::string& name) {
  SimOptions options;
  if (name == "hall") {
    return options;
  }
  if (name == "weak_texture") {
    options.world.texture_strength = 0.5;
    options.world.posters = 10;
  } else if (name == "repeated") {
    options.world.repetition = 0.9;
  } else if (name == "windows") {
    options.world.windows = 12;
    options.world.window_radiance = 14.0;
  } else if (name == "blur") {
    options.sensor.exposure_ms = 28.0;
    options.sensor.samples = 12;
    options.flight.mean_speed_m_s = 1.3;
  } else if (name == "small") {
    options.camera.scale = 0.5;
    options.flight.duration_s = 20.0;
    options.world.length_m = 9.0;
    options.world.width_m = 8.0;
    options.world.height_m = 3.6;
    options.world.furniture = 18;
    options.world.posters = 26;
    options.world.windows = 2;
    options.world.texture_size_px = 256;
  } else {
    ThrowInputError(
        "preset: unknown name '{}', expected one of {}", name, fmt::join(PresetNames(), ", "));
  }
  return options;
}

PinholeParameters SimulatedCamera(const CameraOptions& options) {
  PinholeParameters p;
  const double s = options.scale;
  p.width = static_cast<int>(std::lround(752 * s));
  p.height = static_cast<int>(std::lround(480 * s));
  p.fx = 458.0 * s;
  p.fy = 457.0 * s;
  // Pixel centres keep their place in the scene: u' + 1/2 = s (u + 1/2).
  p.cx = (367.4 + 0.5) * s - 0.5;
  p.cy = (244.6 + 0.5) * s - 0.5;
  p.k1 = -0.282;
  p.k2 = 0.073;
  p.p1 = 1.5e-4;
  p.p2 = -1.2e-4;
  return p;
}

Rigid3 SimulatedExtrinsic() {
  Eigen::Matrix3d R_B_C;
  R_B_C << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // columns: the camera's right, down and ahead in B
  const Eigen::Quaterniond misalignment = ExpSo3({0.008, -0.021, 0.013});
  return {(Eigen::Quaterniond(R_B_C) * misalignment).normalized(), {-0.018, -0.062, 0.011}};
}

}  // namespace deja_view::sim
