#pragma once

#include "deja_view/camera/camera.hpp"

namespace deja_view {

/// Parameters of KannalaBrandtCamera, named as in VINS-Mono's YAML (k2 is OpenCV's fisheye k1).
struct KannalaBrandtParameters {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  double k2 = 0;
  double k3 = 0;
  double k4 = 0;
  double k5 = 0;
  double mu = 0;  ///< [px]
  double mv = 0;  ///< [px]
  double u0 = 0;  ///< [px]
  double v0 = 0;  ///< [px]
};

/// Equidistant fisheye (Kannala & Brandt, PAMI 2006), `cv::fisheye`:
///   theta = angle to the optical axis, phi = angle about it,
///   d = theta + k2 theta^3 + k3 theta^5 + k4 theta^7 + k5 theta^9,
///   u = mu d cos phi + u0, v = mv d sin phi + v0
/// Sees up to the angle where d stops to increase, at most pi; also behind the image plane.
class KannalaBrandtCamera final : public Camera {
 public:
  /// Throws CheckError when a value is not finite or a size or focal length is not positive.
  explicit KannalaBrandtCamera(const KannalaBrandtParameters& parameters);

  std::string ModelType() const override { return "KANNALA_BRANDT"; }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_C,
                                         ProjectionJacobian* J = nullptr) const override;
  Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel) const override;
  double FocalLength() const override;
  std::unique_ptr<Camera> Scaled(double scale) const override;

  const KannalaBrandtParameters& parameters() const { return parameters_; }
  double max_theta() const { return max_theta_; }  ///< largest angle seen [rad]

 private:
  double Radius(double theta, double* derivative) const;
  double LargestAngle() const;

  KannalaBrandtParameters parameters_;
  double max_theta_;
};

}  // namespace deja_view
