#pragma once

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace deja_view::sim {

/// The hall: a box of length x width x height with its corner at the origin of W, z up.
struct WorldOptions {
  double length_m = 16.0;         ///< along x
  double width_m = 12.0;          ///< along y
  double height_m = 5.0;          ///< along z
  double texture_strength = 1.0;  ///< contrast of all surfaces: 0 bare, 1 as a machine hall
  double repetition = 0.0;  ///< share of posters, shelves and wall textures that are copies, 0 to 1
  double dark_share = 0.0;  ///< of furniture that is black and glossy; above 0: so are floor, doors
                            ///<   and screens
  int windows = 3;          ///< bright windows in the walls
  double window_radiance = 4.0;  ///< a white surface under the lamps has about 1
  int furniture = 46;            ///< boxes, shelves and drums
  int posters = 50;
  int texture_size_px = 512;     ///< power of two
  double light_spacing_m = 0.2;  ///< of the baked light

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("length_m", length_m);
    v("width_m", width_m);
    v("height_m", height_m);
    v("texture_strength", texture_strength);
    v("repetition", repetition);
    v("dark_share", dark_share);
    v("windows", windows);
    v("window_radiance", window_radiance);
    v("furniture", furniture);
    v("posters", posters);
    v("texture_size_px", texture_size_px);
    v("light_spacing_m", light_spacing_m);
  }
};

/// The drone's way through the hall.
struct FlightOptions {
  double duration_s = 60.0;
  double mean_speed_m_s = 1.0;  ///< 0.2 to 1.5; the momentary speed varies by about half of it
  double max_yaw_rate_deg_s = 52.0;
  double clearance_m = 0.45;  ///< least distance of the body to walls and furniture
  double hover_s = 1.0;       ///< standing still before the flight begins
  double ground_truth_rate_hz = 200.0;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("duration_s", duration_s);
    v("mean_speed_m_s", mean_speed_m_s);
    v("max_yaw_rate_deg_s", max_yaw_rate_deg_s);
    v("clearance_m", clearance_m);
    v("hover_s", hover_s);
    v("ground_truth_rate_hz", ground_truth_rate_hz);
  }
};

/// How radiance becomes an 8-bit image.
struct SensorOptions {
  double image_rate_hz = 10.0;
  double exposure_ms = 6.0;         ///< blur is the mean over this time, centred on the stamp
  int samples = 4;                  ///< rays per pixel, spread over the pixel and the exposure
  bool auto_exposure = true;        ///< false: the gain of the first image is kept
  double target_level = 0.22;       ///< mean linear level that auto-exposure aims at
  double exposure_adaption = 0.15;  ///< share of the gap that is closed per image
  double vignetting = 0.4;          ///< light falls off as (1 + vignetting tan^2)^-1.5
  double noise = 1.0;  ///< standard deviation [grey levels] in the dark; grows with light
  double gamma = 1.7;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("image_rate_hz", image_rate_hz);
    v("exposure_ms", exposure_ms);
    v("samples", samples);
    v("auto_exposure", auto_exposure);
    v("target_level", target_level);
    v("exposure_adaption", exposure_adaption);
    v("vignetting", vignetting);
    v("noise", noise);
    v("gamma", gamma);
  }
};

/// Continuous-time noise densities as in Kalibr's IMU model; defaults are those of a small MEMS
/// unit.
struct ImuOptions {
  double rate_hz = 200.0;
  double gyro_noise = 1.7e-4;       ///< [rad/s/sqrt(Hz)]
  double accel_noise = 2.0e-3;      ///< [m/s^2/sqrt(Hz)]
  double gyro_bias = 3.0e-3;        ///< standard deviation of the first bias [rad/s]
  double accel_bias = 3.0e-2;       ///< [m/s^2]
  double gyro_bias_walk = 2.0e-5;   ///< [rad/s^2/sqrt(Hz)]
  double accel_bias_walk = 6.0e-4;  ///< [m/s^3/sqrt(Hz)]

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("rate_hz", rate_hz);
    v("gyro_noise", gyro_noise);
    v("accel_noise", accel_noise);
    v("gyro_bias", gyro_bias);
    v("accel_bias", accel_bias);
    v("gyro_bias_walk", gyro_bias_walk);
    v("accel_bias_walk", accel_bias_walk);
  }
};

/// The simulated visual-inertial odometry (VINS-Mono's front end and sliding window).
struct VioOptions {
  int max_points = 150;           ///< tracked at a time
  double min_distance_px = 25.0;  ///< between tracked points, for a 752 pixel wide image
  double pixel_noise_px = 0.3;
  double outlier_fraction = 0.03;  ///< of the tracks
  double keyframe_parallax_px =
      10.0;                        ///< mean shift since the last keyframe, at 460 px focal length
  double drift_min = 0.005;        ///< largest position error over the length of the path: drawn
  double drift_max = 0.01;         ///<   per seed from [drift_min, drift_max]
  double tilt_noise_deg = 0.12;    ///< standard deviation of roll and pitch
  double keyframe_delay_s = 0.2;   ///< from the image to its keyframe message
  double odometry_delay_s = 0.05;  ///< from the image to its odometry message

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("max_points", max_points);
    v("min_distance_px", min_distance_px);
    v("pixel_noise_px", pixel_noise_px);
    v("outlier_fraction", outlier_fraction);
    v("keyframe_parallax_px", keyframe_parallax_px);
    v("drift_min", drift_min);
    v("drift_max", drift_max);
    v("tilt_noise_deg", tilt_noise_deg);
    v("keyframe_delay_s", keyframe_delay_s);
    v("odometry_delay_s", odometry_delay_s);
  }
};

/// A wide-angle pinhole with barrel distortion, much like EuRoC's left camera.
struct CameraOptions {
  double scale = 1.0;  ///< of the 752 x 480 image: 0.5 gives 376 x 240

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("scale", scale);
  }
};

/// Everything that makes a simulated flight. Two flights with the same `seed` and world options but
/// another `flight_seed` are two sessions in one hall.
struct SimOptions {
  std::uint64_t seed = 1;                             ///< of the hall
  std::uint64_t flight_seed = 1;                      ///< of path, noise and drift
  std::int64_t start_stamp_ns = 1600000000000000000;  ///< stamp of the first pose
  int threads = 0;                                    ///< 0: all cores; does not change the result
  WorldOptions world;
  FlightOptions flight;
  CameraOptions camera;
  SensorOptions sensor;
  ImuOptions imu;
  VioOptions vio;

  /// Violations, one line each with key, value and what is allowed; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("seed", seed);
    v("flight_seed", flight_seed);
    v("start_stamp_ns", start_stamp_ns);
    v("threads", threads);
    v("world", world);
    v("flight", flight);
    v("camera", camera);
    v("sensor", sensor);
    v("imu", imu);
    v("vio", vio);
  }
};

/// Names that MakePreset knows: "hall" (the default), "weak_texture", "repeated", "windows", "dark"
/// (black, glossy surfaces that mirror lamps and windows), "blur" and "small" (half resolution, a
/// small hall and 20 s; made in a few seconds, for tests).
std::vector<std::string> PresetNames();

/// Throws InputError for an unknown name.
SimOptions MakePreset(const std::string& name);

/// The simulated camera's lens, at `options.scale`.
PinholeParameters SimulatedCamera(const CameraOptions& options);

/// Where the camera sits on the body. As in EuRoC, the body's x axis points up, y to the right and
/// z ahead.
Rigid3 SimulatedExtrinsic();

}  // namespace deja_view::sim
