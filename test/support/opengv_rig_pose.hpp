#pragma once

#include "deja_view/verification/relative_pose.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include <opengv/absolute_pose/NoncentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>
#include <opengv/sac/Ransac.hpp>
#include <opengv/sac_problems/absolute_pose/AbsolutePoseSacProblem.hpp>

namespace deja_view::test {

/// OpenGV's generalised absolute pose from the same observations that EstimateRelativePose takes,
/// all of them forward: GP3P does not take matches of both directions at once. Deterministic.
class OpengvRigPose {
 public:
  explicit OpengvRigPose(const std::vector<PointObservation>& observations) {
    for (const PointObservation& o : observations) {
      camera_of_.push_back(static_cast<int>(camera_of_.size()));
      bearings_.push_back(o.bearing);
      points_.push_back(o.point);
      centres_.push_back(o.centre);
      rotations_.push_back(Eigen::Matrix3d::Identity());
    }
  }

  /// RANSAC over minimal solutions of three points. Thresholds and confidence as ours.
  RansacResult Ransac(double focal_px, const RelativePoseOptions& options, int max_iterations) {
    using Problem = opengv::sac_problems::absolute_pose::AbsolutePoseSacProblem;
    Adapter adapter(bearings_, camera_of_, points_, centres_, rotations_);
    opengv::sac::Ransac<Problem> ransac;
    ransac.sac_model_ = std::make_shared<Problem>(adapter, Problem::GP3P, false);
    ransac.threshold_ = 1.0 - std::cos(std::atan(options.ransac_threshold_px / focal_px));
    ransac.max_iterations_ = max_iterations;
    ransac.probability_ = options.confidence;
    RansacResult result;
    if (ransac.computeModel(0)) {
      result.T_O_U = FromModel(ransac.model_coefficients_);
      result.inliers = ransac.inliers_;
    }
    return result;
  }

  /// The minimal solver's solutions from three observations.
  std::vector<Rigid3> Minimal(const std::vector<int>& three) {
    Adapter adapter(bearings_, camera_of_, points_, centres_, rotations_);
    std::vector<Rigid3> solutions;
    for (const auto& model : opengv::absolute_pose::gp3p(adapter, three)) {
      solutions.push_back(FromModel(model));
    }
    return solutions;
  }

  /// Linear solution from all `inliers`.
  Rigid3 Gpnp(const std::vector<int>& inliers) {
    Adapter adapter(bearings_, camera_of_, points_, centres_, rotations_);
    return FromModel(opengv::absolute_pose::gpnp(adapter, inliers));
  }

  /// Non-linear least squares over `inliers`.
  Rigid3 Refine(const Rigid3& T_O_U, const std::vector<int>& inliers) {
    Adapter adapter(bearings_, camera_of_, points_, centres_, rotations_);
    const Rigid3 T_U_O = T_O_U.Inverse();
    adapter.sett(T_U_O.t);
    adapter.setR(T_U_O.R());
    return FromModel(opengv::absolute_pose::optimize_nonlinear(adapter, inliers));
  }

 private:
  using Adapter = opengv::absolute_pose::NoncentralAbsoluteAdapter;

  /// OpenGV's models carry points of the rig's frame O to the points' frame U.
  static Rigid3 FromModel(const opengv::transformation_t& model) {
    const Eigen::Matrix3d R = model.leftCols<3>();
    const Rigid3 T_U_O{Eigen::Quaterniond(R).normalized(), model.col(3)};
    return T_U_O.Inverse();
  }

  opengv::bearingVectors_t bearings_;
  std::vector<int> camera_of_;
  opengv::points_t points_;
  opengv::translations_t centres_;
  opengv::rotations_t rotations_;
};

}  // namespace deja_view::test
