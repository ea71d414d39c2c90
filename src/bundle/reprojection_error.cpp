#include "reprojection_error.hpp"

#include "deja_view/geometry/rigid3.hpp"

#include <algorithm>

#include "camera_block.hpp"
#include "delta_rotation.hpp"

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

bool ReprojectionError::Evaluate(double const* const* parameters,
                                 double* residuals,
                                 double** jacobians) const {
  const ImageReference& ref = reference_;
  const DeltaRotation body(parameters[kBody]);
  const DeltaRotation mount(parameters[kExtrinsics]);
  const double dt = *parameters[kTimeOffset];
  const Eigen::Map<const Eigen::Vector3d> t_W_B(parameters[kBody] + 3);
  const Eigen::Map<const Eigen::Vector3d> p_W(parameters[kPoint]);
  const Eigen::Map<const Eigen::Vector3d> t_B_C(parameters[kExtrinsics] + 3);
  const Eigen::Matrix3d R_B_W = (body.R * ref.R_W_B).transpose();
  const Eigen::Matrix3d R_C_B = (mount.R * ref.R_B_C).transpose();
  const Eigen::Vector3d turn = -dt * ref.angular_velocity_B;
  const Eigen::Matrix3d R_turn =
      dt == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : DeltaRotation(turn.data()).R;

  const Eigen::Vector3d v_W = p_W - t_W_B - dt * ref.velocity_W;
  const Eigen::Vector3d p_B = R_turn * (R_B_W * v_W);
  const Eigen::Vector3d lever_B = p_B - t_B_C;
  const bool differentiate = jacobians != nullptr;
  const auto block = [&](Block b) { return differentiate ? jacobians[b] : nullptr; };
  Camera::ProjectionJacobian J_pi;
  const auto pixel = ref.camera->Project(parameters[kProjection],
                                         parameters[kDistortion],
                                         R_C_B * lever_B,
                                         differentiate ? &J_pi : nullptr,
                                         block(kProjection),
                                         block(kDistortion));
  if (!pixel) {
    SetUnseen(residuals, jacobians);
    return true;
  }
  Eigen::Map<Eigen::Vector2d>{residuals} = inverse_sigma_ * (*pixel - pixel_);
  if (!differentiate) {
    return true;
  }
  const Eigen::Matrix<double, 2, 3> J_body_frame = inverse_sigma_ * J_pi * R_C_B;
  const Eigen::Matrix<double, 2, 3> J_world = J_body_frame * R_turn * R_B_W;
  if (jacobians[kBody] != nullptr) {
    auto J = Map2<6>(jacobians[kBody]);
    J.leftCols<3>() = J_world * Skew(v_W) * body.J;
    J.rightCols<3>() = -J_world;
  }
  if (jacobians[kPoint] != nullptr) {
    Map2<3>(jacobians[kPoint]) = J_world;
  }
  if (jacobians[kExtrinsics] != nullptr) {
    auto J = Map2<6>(jacobians[kExtrinsics]);
    J.leftCols<3>() = J_body_frame * Skew(lever_B) * mount.J;
    J.rightCols<3>() = -J_body_frame;
  }
  if (jacobians[kTimeOffset] != nullptr) {
    Eigen::Map<Eigen::Vector2d>{jacobians[kTimeOffset]} =
        -J_body_frame * ref.angular_velocity_B.cross(p_B) - J_world * ref.velocity_W;
  }
  for (const Block b : {kProjection, kDistortion}) {
    if (jacobians[b] != nullptr) {
      Eigen::Map<CameraBlock::RowMajor2X>{jacobians[b], 2, parameter_block_sizes()[b]} *=
          inverse_sigma_;
    }
  }
  return true;
}

}  // namespace deja_view::internal
