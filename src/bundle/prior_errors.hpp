#pragma once

#include "deja_view/bundle/bundle_problem.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

namespace deja_view::internal {

/// A body's pose as the solver moves it: R_W_B = Exp(w) R_reference; block (w [rad], t_W_B [m]).
template <typename T>
struct BodyPose {
  BodyPose(const T* block, const Eigen::Quaterniond& q_reference)
      : t(block[3], block[4], block[5]) {
    T delta[4];  // w, x, y, z
    ceres::AngleAxisToQuaternion(block, delta);
    q = Eigen::Quaternion<T>(delta[0], delta[1], delta[2], delta[3]) *
        q_reference.template cast<T>();
  }

  Eigen::Quaternion<T> q;
  Eigen::Matrix<T, 3, 1> t;
};

/// Rotation vector of a small rotation to third order: twice the vector part.
template <typename T>
Eigen::Matrix<T, 3, 1> SmallRotation(const Eigen::Quaternion<T>& q) {
  return T(q.w() < T(0) ? -2.0 : 2.0) * q.vec();
}

/// (R_from^T (t_to - t_from) - t_prior) / sigma_m and the rotation's difference / sigma_rad.
/// Parameter blocks: both bodies.
struct RelativePoseError {
  RelativePosePrior prior;
  Eigen::Quaterniond q_from;  ///< references
  Eigen::Quaterniond q_to;

  template <typename T>
  bool operator()(const T* from_block, const T* to_block, T* residuals) const {
    const BodyPose<T> from(from_block, q_from);
    const BodyPose<T> to(to_block, q_to);
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    const Eigen::Quaternion<T> q_to_from = from.q.conjugate();
    r.template head<3>() =
        (q_to_from * (to.t - from.t) - prior.T_from_to.t.template cast<T>()) / T(prior.sigma_m);
    r.template tail<3>() =
        SmallRotation<T>(prior.T_from_to.q.conjugate().template cast<T>() * (q_to_from * to.q)) /
        T(prior.sigma_rad);
    return true;
  }

  static ceres::CostFunction* Create(const RelativePoseError& error) {
    return new ceres::AutoDiffCostFunction<RelativePoseError, 6, 6, 6>(
        new RelativePoseError(error));
  }
};

/// Where the body's vertical misses the world's, over sigma_rad: x and y of R_W_B up_B.
struct TiltError {
  TiltPrior prior;
  Eigen::Quaterniond q_reference;

  template <typename T>
  bool operator()(const T* block, T* residuals) const {
    const Eigen::Matrix<T, 3, 1> up =
        BodyPose<T>(block, q_reference).q * Eigen::Matrix<T, 3, 1>(prior.up_B.template cast<T>());
    residuals[0] = up.x() / T(prior.sigma_rad);
    residuals[1] = up.y() / T(prior.sigma_rad);
    return true;
  }

  static ceres::CostFunction* Create(const TiltError& error) {
    return new ceres::AutoDiffCostFunction<TiltError, 2, 6>(new TiltError(error));
  }
};

/// (t - t_prior) / sigma_m and the rotation's difference / sigma_rad.
struct PoseError {
  PosePrior prior;
  Eigen::Quaterniond q_reference;

  template <typename T>
  bool operator()(const T* block, T* residuals) const {
    const BodyPose<T> body(block, q_reference);
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r.template head<3>() = (body.t - prior.T_W_B.t.template cast<T>()) / T(prior.sigma_m);
    r.template tail<3>() = SmallRotation<T>(prior.T_W_B.q.conjugate().template cast<T>() * body.q) /
                           T(prior.sigma_rad);
    return true;
  }

  static ceres::CostFunction* Create(const PoseError& error) {
    return new ceres::AutoDiffCostFunction<PoseError, 6, 6>(new PoseError(error));
  }
};

}  // namespace deja_view::internal
