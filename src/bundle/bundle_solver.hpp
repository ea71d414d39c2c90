#pragma once

#include "deja_view/bundle/bundle_options.hpp"
#include "deja_view/bundle/bundle_problem.hpp"

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "camera_block.hpp"
#include "reprojection_error.hpp"
#include <Eigen/SparseCore>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

namespace deja_view::internal {

/// The least-squares problem over some points of a BundleProblem: reprojection errors and priors of
/// poses under Cauchy kernels, and the priors of tilts and cameras.
class BundleSolver {
 public:
  /// `points` are indices into problem.points. Refers to nothing of `problem` afterwards.
  BundleSolver(const BundleOptions& options,
               const BundleProblem& problem,
               const std::vector<int>& points);

  struct Report {
    bool is_usable = false;
    bool was_stopped = false;
    int iterations = 0;
  };
  /// One thread: the same bits every time. `goes_on` hears of each iteration's share of the most
  /// that may be; false from it stops the solver.
  Report Solve(const std::function<bool(double share)>& goes_on = {});

  /// Writes poses, points and refined cameras back.
  void Store(BundleProblem* problem) const;

  /// d residuals / d (bodies, cameras, points) with the kernel's weights, in this order: six
  /// columns per image (zero where it has no residual or is held), then those of refined cameras,
  /// then three per point, from column `first_point` on.
  struct Linearisation {
    Eigen::SparseMatrix<double, Eigen::RowMajor> J;
    int first_point = 0;
  };
  Linearisation Linearise();

 private:
  struct CameraState {
    explicit CameraState(const BundleCamera& camera);

    CameraBlock block;
    Eigen::Quaterniond q_B_C;  ///< reference
    std::array<double, 6> extrinsics{};
    double time_offset_s;
    std::vector<double> projection;
    std::vector<double> distortion;
  };
  void AddImages(const BundleProblem& problem);
  void AddObservations(const BundleProblem& problem);
  void AddPriors(const BundleProblem& problem);
  void AddCameraPriors();
  void HoldCameras(const BundleProblem& problem);

  BundleOptions options_;
  ceres::CauchyLoss loss_;
  ceres::CauchyLoss prior_loss_;
  std::vector<int> point_indices_;
  std::deque<CameraState> cameras_;  ///< never move: residuals point to them
  std::vector<ImageReference> references_;
  std::vector<Eigen::Quaterniond> q_W_B_;  ///< references
  std::vector<std::array<double, 6>> bodies_;
  std::vector<Eigen::Vector3d> points_;
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace deja_view::internal
