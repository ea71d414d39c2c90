#pragma once

#include "deja_view/camera/camera.hpp"

namespace deja_view {

/// Parameters of MeiCamera, named as in VINS-Mono's YAML.
struct MeiParameters {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  double xi = 0;   ///< mirror parameter, >= 0; 0 is a pinhole
  double k1 = 0;   ///< radial
  double k2 = 0;
  double p1 = 0;  ///< tangential
  double p2 = 0;
  double gamma1 = 0;  ///< generalised focal lengths [px]
  double gamma2 = 0;
  double u0 = 0;  ///< [px]
  double v0 = 0;  ///< [px]
};

/// Unified omnidirectional camera (Mei & Rives, ICRA 2007), `cv::omnidir`: the point is projected
/// on the unit sphere, from there through a centre shifted by xi on a plane, (x, y) = (X, Y) / (Z +
/// xi |P|), then distorted as in PinholeCamera. Sees where this map is one-to-one: Z/|P| > -xi for
/// xi <= 1, Z/|P| > -1/xi otherwise.
class MeiCamera final : public Camera {
 public:
  /// Throws CheckError when a value is not finite, xi is negative, or a size or focal length is not
  /// positive.
  explicit MeiCamera(const MeiParameters& parameters);

  std::string ModelType() const override { return "MEI"; }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_C,
                                         ProjectionJacobian* J = nullptr) const override;
  Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel) const override;
  double FocalLength() const override;
  std::unique_ptr<Camera> Scaled(double scale) const override;

  const MeiParameters& parameters() const { return parameters_; }
  /// Of the undistorted plane; beyond it nothing is seen.
  double max_radius_squared() const { return max_radius_squared_; }

 private:
  MeiParameters parameters_;
  double max_radius_squared_;
};

}  // namespace deja_view
