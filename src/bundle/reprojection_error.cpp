#include "reprojection_error.hpp"

#include "deja_view/geometry/rigid3.hpp"

#include <algorithm>

namespace deja_view::internal {
namespace {

template <int kColumns>
Eigen::Map<Eigen::Matrix<double, 2, kColumns, Eigen::RowMajor>> Map2(double* jacobian) {
  return Eigen::Map<Eigen::Matrix<double, 2, kColumns, Eigen::RowMajor>>(jacobian);
}

}  // namespace

ReprojectionError::ReprojectionError(const ImageReference& reference,
                                     const Eigen::Vector2d& pixel,
                                     double sigma_px)
    : reference_(reference), pixel_(pixel), inverse_sigma_(1.0 / sigma_px) {
  set_num_residuals(2);
  *mutable_parameter_block_sizes() = {
      6, 3, 6, 1, reference.camera->projection_size(), reference.camera->distortion_size()};
}

void ReprojectionError::SetUnseen(double* residuals, double** jacobians) const {
  residuals[0] = residuals[1] = kUnseenPx * inverse_sigma_;
  if (jacobians == nullptr) {
    return;
  }
  for (std::size_t block = 0; block < parameter_block_sizes().size(); ++block) {
    if (jacobians[block] != nullptr) {
      std::fill_n(jacobians[block], 2 * parameter_block_sizes()[block], 0.0);
    }
  }
}

ReprojectionError::Chain::Chain(const ImageReference& reference, double const* const* parameters)
    : body(parameters[kBody]),
      mount(parameters[kExtrinsics]),
      R_B_W((body.R * reference.R_W_B).transpose()),
      R_C_B((mount.R * reference.R_B_C).transpose()) {
  const double dt = *parameters[kTimeOffset];
  const Eigen::Map<const Eigen::Vector3d> t_W_B(parameters[kBody] + 3);
  const Eigen::Map<const Eigen::Vector3d> p_W(parameters[kPoint]);
  const Eigen::Map<const Eigen::Vector3d> t_B_C(parameters[kExtrinsics] + 3);
  v_W = p_W - t_W_B - dt * reference.velocity_W;
  if (dt != 0) {
    const Eigen::Vector3d turn = -dt * reference.angular_velocity_B;
    R_B_W = (DeltaRotation(turn.data()).R * R_B_W).eval();
  }
  p_B = R_B_W * v_W;
  lever_B = p_B - t_B_C;
}

bool ReprojectionError::Evaluate(double const* const* parameters,
                                 double* residuals,
                                 double** jacobians) const {
  const Chain chain(reference_, parameters);
  const bool differentiate = jacobians != nullptr;
  const auto block = [&](Block b) { return differentiate ? jacobians[b] : nullptr; };
  Camera::ProjectionJacobian J_pi;
  const auto pixel = reference_.camera->Project(parameters[kProjection],
                                                parameters[kDistortion],
                                                chain.R_C_B * chain.lever_B,
                                                differentiate ? &J_pi : nullptr,
                                                block(kProjection),
                                                block(kDistortion));
  if (!pixel) {
    SetUnseen(residuals, jacobians);
    return true;
  }
  Eigen::Map<Eigen::Vector2d>{residuals} = inverse_sigma_ * (*pixel - pixel_);
  if (differentiate) {
    SetJacobians(chain, J_pi, jacobians);
  }
  return true;
}

void ReprojectionError::SetJacobians(const Chain& chain,
                                     const Camera::ProjectionJacobian& J_pi,
                                     double** jacobians) const {
  const Eigen::Matrix<double, 2, 3> J_B = inverse_sigma_ * J_pi * chain.R_C_B;
  const Eigen::Matrix<double, 2, 3> J_W = J_B * chain.R_B_W;
  if (jacobians[kBody] != nullptr) {
    auto J = Map2<6>(jacobians[kBody]);
    J.leftCols<3>() = J_W * Skew(chain.v_W) * chain.body.J;
    J.rightCols<3>() = -J_W;
  }
  if (jacobians[kPoint] != nullptr) {
    Map2<3>(jacobians[kPoint]) = J_W;
  }
  if (jacobians[kExtrinsics] != nullptr) {
    auto J = Map2<6>(jacobians[kExtrinsics]);
    J.leftCols<3>() = J_B * Skew(chain.lever_B) * chain.mount.J;
    J.rightCols<3>() = -J_B;
  }
  if (jacobians[kTimeOffset] != nullptr) {
    Eigen::Map<Eigen::Vector2d>{jacobians[kTimeOffset]} =
        -J_B * reference_.angular_velocity_B.cross(chain.p_B) - J_W * reference_.velocity_W;
  }
  for (const Block b : {kProjection, kDistortion}) {
    if (jacobians[b] != nullptr) {
      Eigen::Map<CameraBlock::RowMajor2X>{jacobians[b], 2, parameter_block_sizes()[b]} *=
          inverse_sigma_;
    }
  }
}

}  // namespace deja_view::internal
