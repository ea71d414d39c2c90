#include "deja_view/lab/sim/options.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <cmath>

#include <fmt/format.h>

namespace deja_view::sim {
namespace {

std::vector<std::string> Violations(const WorldOptions& o) {
  Requirements r;
  r.Range("length_m", o.length_m, 6.0, 60.0);
  r.Range("width_m", o.width_m, 6.0, 60.0);
  r.Range("height_m", o.height_m, 2.8, 15.0);
  r.Range("texture_strength", o.texture_strength, 0.0, 1.5);
  r.Range("repetition", o.repetition, 0.0, 1.0);
  r.Range("dark_share", o.dark_share, 0.0, 1.0);
  r.Range("windows", o.windows, 0, 40);
  r.Range("window_radiance", o.window_radiance, 0.1, 100.0);
  r.Range("furniture", o.furniture, 0, 500);
  r.Range("posters", o.posters, 0, 500);
  r.Range("texture_size_px", o.texture_size_px, 64, 2048);
  r.That((o.texture_size_px & (o.texture_size_px - 1)) == 0,
         fmt::format("texture_size_px: {} is not a power of two", o.texture_size_px));
  r.Range("light_spacing_m", o.light_spacing_m, 0.05, 2.0);
  return r.errors();
}

std::vector<std::string> Violations(const FlightOptions& o) {
  Requirements r;
  r.Range("duration_s", o.duration_s, 2.0, 3600.0);
  r.Range("mean_speed_m_s", o.mean_speed_m_s, 0.2, 1.5);
  r.Range("max_yaw_rate_deg_s", o.max_yaw_rate_deg_s, 20.0, 180.0);
  r.Range("clearance_m", o.clearance_m, 0.1, 0.6);
  r.Range("hover_s", o.hover_s, 0.0, 60.0);
  r.Range("ground_truth_rate_hz", o.ground_truth_rate_hz, 10.0, 1000.0);
  return r.errors();
}

std::vector<std::string> Violations(const SensorOptions& o) {
  Requirements r;
  r.Range("image_rate_hz", o.image_rate_hz, 1.0, 60.0);
  r.Range("exposure_ms", o.exposure_ms, 0.0, 100.0);
  r.That(o.exposure_ms * o.image_rate_hz <= 1000.0,
         fmt::format("exposure_ms: {} is longer than the time between images", o.exposure_ms));
  r.Range("samples", o.samples, 1, 64);
  r.Range("target_level", o.target_level, 0.01, 0.9);
  r.Range("exposure_adaption", o.exposure_adaption, 0.0, 1.0);
  r.Range("vignetting", o.vignetting, 0.0, 2.0);
  r.Range("noise", o.noise, 0.0, 30.0);
  r.Range("gamma", o.gamma, 1.0, 3.0);
  return r.errors();
}

std::vector<std::string> Violations(const ImuOptions& o) {
  Requirements r;
  r.Range("rate_hz", o.rate_hz, 20.0, 1000.0);
  r.Range("gyro_noise", o.gyro_noise, 0.0, 1.0);
  r.Range("accel_noise", o.accel_noise, 0.0, 1.0);
  r.Range("gyro_bias", o.gyro_bias, 0.0, 1.0);
  r.Range("accel_bias", o.accel_bias, 0.0, 5.0);
  r.Range("gyro_bias_walk", o.gyro_bias_walk, 0.0, 1.0);
  r.Range("accel_bias_walk", o.accel_bias_walk, 0.0, 1.0);
  return r.errors();
}

std::vector<std::string> Violations(const VioOptions& o) {
  Requirements r;
  r.Range("max_points", o.max_points, 10, 1000);
  r.Range("min_distance_px", o.min_distance_px, 2.0, 100.0);
  r.Range("pixel_noise_px", o.pixel_noise_px, 0.0, 5.0);
  r.Range("outlier_fraction", o.outlier_fraction, 0.0, 0.9);
  r.Range("keyframe_parallax_px", o.keyframe_parallax_px, 0.0, 200.0);
  r.Range("drift_min", o.drift_min, 0.0, 0.2);
  r.Range("drift_max", o.drift_max, 0.0, 0.2);
  r.That(o.drift_min <= o.drift_max,
         fmt::format("drift_min: {} is above drift_max {}", o.drift_min, o.drift_max));
  r.Range("tilt_noise_deg", o.tilt_noise_deg, 0.0, 5.0);
  r.Range("keyframe_delay_s", o.keyframe_delay_s, 0.0, 2.0);
  r.Range("odometry_delay_s", o.odometry_delay_s, 0.0, 2.0);
  return r.errors();
}

}  // namespace

std::vector<std::string> SimOptions::Validate() const {
  Requirements r;
  r.Range("threads", threads, 0, 1024);
  r.That(start_stamp_ns >= 0 && start_stamp_ns < 4000000000LL * 1000000000LL,
         "start_stamp_ns",
         start_stamp_ns,
         "a stamp of ROS");
  r.Group("world", Violations(world));
  r.Group("flight", Violations(flight));
  r.Range("camera.scale", camera.scale, 0.1, 2.0);
  r.Group("sensor", Violations(sensor));
  r.Group("imu", Violations(imu));
  r.Group("vio", Violations(vio));
  return r.errors();
}

std::vector<std::string> PresetNames() {
  return {"hall", "weak_texture", "repeated", "windows", "dark", "blur", "small"};
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
  } else if (name == "dark") {
    options.world.dark_share = 0.6;
    options.world.windows = 6;
    options.world.window_radiance = 8.0;
    options.world.posters = 30;
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
