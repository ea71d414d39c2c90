#pragma once

#include "deja_view/base/angles.hpp"
#include "deja_view/verification/relative_pose.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace deja_view::test {

constexpr double kRigFocalPx = 460.0;

struct RigPoseSceneOptions {
  int cameras = 3;              ///< of the old body: a real one and virtual ones
  double radius_m = 0.3;        ///< of the virtual cameras about the real one
  double turn_deg = 15.0;       ///< of the virtual cameras, about each axis
  int matches = 100;            ///< each seen by one of the cameras
  double pixel_noise = 1.0;     ///< [px] per axis
  double depth_noise = 0.02;    ///< of the depth
  double outlier_ratio = 0.5;   ///< of the matches
  double tilt_noise_deg = 0.2;  ///< of VIO's roll and pitch
  std::uint32_t seed = 1;
};

/// Points that the current body U located, seen by the rig of an old body O; all forward.
struct RigPoseScene {
  Rigid3 T_O_U;
  GravityPair gravity;
  std::vector<PointObservation> observations;
  int outliers = 0;
};

class RigPoseSceneMaker {
 public:
  explicit RigPoseSceneMaker(const RigPoseSceneOptions& options)
      : options_(options), rng_(options.seed) {}

  RigPoseScene Make() {
    RigPoseScene scene;
    const Rigid3 T_W_O{ExpSo3({0.1, -0.2, 0.5}), {1, 2, 1}};
    const Rigid3 T_W_U{ExpSo3({-0.1, 0.1, 0.5 + 0.4 * Uniform()}),
                       {1.5, 1.8 + 0.5 * Uniform(), 1.3}};
    scene.T_O_U = T_W_O.Inverse() * T_W_U;
    scene.gravity = {LevelRotation(T_W_O.q * TiltNoise()), LevelRotation(T_W_U.q * TiltNoise())};
    std::vector<Rigid3> rig = {T_B_C_};
    while (static_cast<int>(rig.size()) < options_.cameras) {
      rig.push_back(T_B_C_ * VirtualCamera());
    }
    while (static_cast<int>(scene.observations.size()) < options_.matches) {
      AddMatch(rig, &scene);
    }
    return scene;
  }

 private:
  double Uniform() { return std::uniform_real_distribution<double>(-1, 1)(rng_); }
  double Normal() { return normal_(rng_); }
  Eigen::Vector3d Cube(double range) {
    const double x = Uniform();
    const double y = Uniform();
    return range * Eigen::Vector3d(x, y, Uniform());
  }

  Eigen::Quaterniond TiltNoise() {
    const double x = Normal();
    return ExpSo3(options_.tilt_noise_deg * kDegree * Eigen::Vector3d(x, Normal(), 0));
  }

  Rigid3 VirtualCamera() {
    Eigen::Vector3d t = Cube(1.0);
    t *= options_.radius_m / std::max(1e-9, t.norm());
    return {ExpSo3(Cube(options_.turn_deg * kDegree)), t};
  }

  void AddMatch(const std::vector<Rigid3>& rig, RigPoseScene* scene) {
    const double x = 2.0 * Uniform();
    const double y = 1.5 * Uniform();
    const Eigen::Vector3d p_C(x, y, 4.5 + 2.0 * Uniform());
    const Rigid3& T_O_C = rig[rng_() % rig.size()];
    PointObservation o;
    o.sight = T_B_C_.q * p_C.normalized();
    o.depth_sigma = std::max(0.01, options_.depth_noise) * p_C.norm();
    const Eigen::Vector3d truth = T_B_C_ * p_C;
    o.point = truth + o.sight * (options_.depth_noise * p_C.norm() * Normal());
    o.centre = T_O_C.t;
    const Eigen::Vector3d ray = (scene->T_O_U * truth - o.centre).normalized();
    const Eigen::Vector3d u = ray.unitOrthogonal();
    const double sigma = options_.pixel_noise / kRigFocalPx;
    const double noise_u = sigma * Normal();
    o.bearing = (ray + noise_u * u + sigma * Normal() * ray.cross(u)).normalized();
    if (0.5 + 0.5 * Uniform() < options_.outlier_ratio) {
      const double along_x = 0.8 * Uniform();
      o.bearing = T_O_C.q * Eigen::Vector3d(along_x, 0.5 * Uniform(), 1.0).normalized();
      ++scene->outliers;
    }
    scene->observations.push_back(o);
  }

  RigPoseSceneOptions options_;
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
  Rigid3 T_B_C_{ExpSo3({0.1, 1.5, -0.2}), {0.05, -0.06, 0.01}};
};

inline RigPoseScene MakeRigPoseScene(const RigPoseSceneOptions& options) {
  return RigPoseSceneMaker(options).Make();
}

}  // namespace deja_view::test
