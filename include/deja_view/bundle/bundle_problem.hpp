#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/features/types.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// A camera on the body. Adjusted where the options ask for it.
struct BundleCamera {
  std::shared_ptr<const Camera> camera;
  Rigid3 T_B_C;
  double time_offset_s = 0;  ///< images show what was seen at their stamp plus this
};

/// A posed image and the corners found in it.
struct BundleImage {
  int camera = 0;  ///< index into BundleProblem::cameras
  std::int64_t stamp_ns = 0;
  Rigid3 T_W_B;                                                  ///< at the stamp; adjusted
  Eigen::Vector3d velocity_W = Eigen::Vector3d::Zero();          ///< [m/s], for the time offset
  Eigen::Vector3d angular_velocity_B = Eigen::Vector3d::Zero();  ///< [rad/s], for the time offset
  std::vector<Eigen::Vector2f> keypoints;                        ///< [px]
  std::vector<Descriptor> descriptors;                           ///< of the keypoints
  std::vector<std::int64_t> track_ids;  ///< the VIO's track of each keypoint, -1: none
};

/// What an odometry measured between two bodies.
struct RelativePosePrior {
  int from = -1;  ///< image
  int to = -1;
  Rigid3 T_from_to;
  double sigma_m = 0.01;     ///< per axis
  double sigma_rad = 0.001;  ///< per axis
};

/// Gravity as a body's accelerometers have it: holds roll and pitch.
struct TiltPrior {
  int image = -1;
  Eigen::Vector3d up_B = Eigen::Vector3d::UnitZ();
  double sigma_rad = 0.005;
};

/// A pose that was given: holds the map where it is, and its scale.
struct PosePrior {
  int image = -1;
  Rigid3 T_W_B;
  double sigma_m = 0.05;    ///< per axis
  double sigma_rad = 0.02;  ///< per axis
};

/// Two images that show the same place, however far apart they were taken: a verified loop.
struct BundleLoop {
  int from = -1;
  int to = -1;
  Rigid3 T_from_to;  ///< of the bodies [m]
};

/// A keypoint of an image.
struct BundleObservation {
  int image = -1;
  int keypoint = -1;

  friend bool operator==(const BundleObservation& a, const BundleObservation& b) {
    return a.image == b.image && a.keypoint == b.keypoint;
  }
};

/// A point of the map.
struct BundlePoint {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  std::vector<BundleObservation> observations;  ///< at most one per image, images ascending
  double rms_px = 0;                            ///< reprojection error over the observations
  double parallax_rad = 0;                      ///< largest angle between two of its rays
};

/// What AdjustBundle improves: cameras, poses and, found by it, points. Images are in the order of
/// flight; their poses are good to some centimetres and a degree, as an odometry with loops closed,
/// motion capture or a depth camera's tracking gives them.
struct BundleProblem {
  std::vector<BundleCamera> cameras;
  std::vector<BundleImage> images;
  std::vector<RelativePosePrior> relative_priors;
  std::vector<TiltPrior> tilt_priors;
  std::vector<PosePrior> pose_priors;  ///< without any, the whole stays about where it is
  std::vector<BundleLoop> loops;       ///< matched beside the pairs that the poses suggest
  std::vector<BundlePoint> points;     ///< result

  /// T_W_C of an image at the time at which it was taken (stamp plus time offset).
  Rigid3 CameraPose(int image) const;
};

}  // namespace deja_view
