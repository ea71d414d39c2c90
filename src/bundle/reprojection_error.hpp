#pragma once

#include "camera_block.hpp"
#include "delta_rotation.hpp"
#include <Eigen/Core>
#include <ceres/cost_function.h>

namespace deja_view::internal {

/// What the observations of an image have in common. Rotations are references that the solver's
/// rotation vectors turn: R_W_B = Exp(w) R_W_B_reference.
struct ImageReference {
  Eigen::Matrix3d R_W_B = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_B_C = Eigen::Matrix3d::Identity();
  Eigen::Vector3d velocity_W = Eigen::Vector3d::Zero();          ///< [m/s]
  Eigen::Vector3d angular_velocity_B = Eigen::Vector3d::Zero();  ///< [rad/s]
  CameraBlock* camera = nullptr;
};

/// Reprojection error of a point in an image (Eq. 4: one term inside rho), over its standard
/// deviation:
///   r = (pi(p_C) - pixel) / sigma,
///   p_C = T_B_C^-1 Exp(-omega dt) R_W_B^T (p_W - t_W_B - v dt)
/// Parameter blocks: body (w [rad], t_W_B [m]), point p_W [m], extrinsics (w [rad], t_B_C [m]),
/// time offset dt [s], the camera's projection, the camera's distortion. A point that the camera
/// does not see costs as much as one a hundred pixels off, whose derivative is zero.
class ReprojectionError : public ceres::CostFunction {
 public:
  enum Block { kBody, kPoint, kExtrinsics, kTimeOffset, kProjection, kDistortion };
  static constexpr double kUnseenPx = 100.0;

  /// `reference` outlives this.
  ReprojectionError(const ImageReference& reference, const Eigen::Vector2d& pixel, double sigma_px);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  /// The way from the point to the camera at some parameters.
  struct Chain {
    Chain(const ImageReference& reference, double const* const* parameters);

    DeltaRotation body;
    DeltaRotation mount;
    Eigen::Matrix3d R_B_W;  ///< when the image is taken
    Eigen::Matrix3d R_C_B;
    Eigen::Vector3d v_W;      ///< [m] from the body to the point
    Eigen::Vector3d p_B;      ///< [m]
    Eigen::Vector3d lever_B;  ///< [m] from the camera to the point
  };

  void SetJacobians(const Chain& chain,
                    const Camera::ProjectionJacobian& J_pi,
                    double** jacobians) const;
  void SetUnseen(double* residuals, double** jacobians) const;

  const ImageReference& reference_;
  Eigen::Vector2d pixel_;
  double inverse_sigma_;
};

}  // namespace deja_view::internal
