#pragma once

#include "deja_view/camera/camera.hpp"

namespace deja_view {

/// Parameters of PinholeCamera, named as in VINS-Mono's YAML and OpenCV.
struct PinholeParameters {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  double fx = 0;   ///< [px]
  double fy = 0;   ///< [px]
  double cx = 0;   ///< [px]
  double cy = 0;   ///< [px]
  double k1 = 0;   ///< radial
  double k2 = 0;
  double p1 = 0;  ///< tangential
  double p2 = 0;
};

/// Pinhole with radial-tangential distortion, `cv::projectPoints` with four coefficients:
///   (x, y) = (X/Z, Y/Z), s = x^2 + y^2
///   u = fx (x (1 + k1 s + k2 s^2) + 2 p1 x y + p2 (s + 2 x^2)) + cx
///   v = fy (y (1 + k1 s + k2 s^2) + p1 (s + 2 y^2) + 2 p2 x y) + cy
/// Sees nothing at Z <= 0 nor beyond the radius where the radial polynomial stops to increase.
class PinholeCamera final : public Camera {
 public:
  /// Throws CheckError when a value is not finite or a size or focal length is not positive.
  explicit PinholeCamera(const PinholeParameters& parameters);

  std::string ModelType() const override { return "PINHOLE"; }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_C,
                                         ProjectionJacobian* J = nullptr) const override;
  Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel) const override;
  double FocalLength() const override;
  std::unique_ptr<Camera> Scaled(double scale) const override;

  const PinholeParameters& parameters() const { return parameters_; }
  /// Of the undistorted plane; beyond it nothing is seen.
  double max_radius_squared() const { return max_radius_squared_; }

 private:
  PinholeParameters parameters_;
  double max_radius_squared_;
};

}  // namespace deja_view
