#include "bundle_solver.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>

#include "prior_errors.hpp"
#include <ceres/iteration_callback.h>
#include <ceres/normal_prior.h>
#include <ceres/ordered_groups.h>
#include <ceres/solver.h>

namespace deja_view::internal {
namespace {

/// Normal prior on a block at where it is, with one standard deviation per entry.
void AddNormalPrior(const std::vector<double>& sigmas, double* block, ceres::Problem* problem) {
  const auto size = static_cast<Eigen::Index>(sigmas.size());
  const Eigen::Map<const Eigen::VectorXd> sigma(sigmas.data(), size);
  const Eigen::MatrixXd A = sigma.cwiseInverse().asDiagonal();
  const Eigen::VectorXd mean = Eigen::Map<const Eigen::VectorXd>(block, size);
  problem->AddResidualBlock(
      std::make_unique<ceres::NormalPrior>(A, mean).release(), nullptr, block);
}

class StopOnRequest : public ceres::IterationCallback {
 public:
  StopOnRequest(int max_iterations, const std::function<bool(double share)>& goes_on)
      : max_iterations_(max_iterations), goes_on_(goes_on) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    const double share = static_cast<double>(iteration.iteration) / max_iterations_;
    return !goes_on_ || goes_on_(share) ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
  }

 private:
  int max_iterations_;
  const std::function<bool(double share)>& goes_on_;
};

}  // namespace

BundleSolver::CameraState::CameraState(const BundleCamera& camera)
    : block(*camera.camera),
      q_B_C(camera.T_B_C.q),
      time_offset_s(camera.time_offset_s),
      projection(block.parameters().projection),
      distortion(block.parameters().distortion) {
  std::copy_n(camera.T_B_C.t.data(), 3, extrinsics.begin() + 3);
}

BundleSolver::BundleSolver(const BundleOptions& options,
                           const BundleProblem& problem,
                           const std::vector<int>& points)
    : options_(options),
      loss_(options.kernel_sigmas),
      prior_loss_(options.prior_kernel_sigmas),
      point_indices_(points),
      references_(problem.images.size()),
      bodies_(problem.images.size()),
      points_(points.size()) {
  for (const BundleCamera& camera : problem.cameras) {
    cameras_.emplace_back(camera);
  }
  ceres::Problem::Options problem_options;
  problem_options.disable_all_safety_checks = true;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_ = std::make_unique<ceres::Problem>(problem_options);
  AddImages(problem);
  AddObservations(problem);
  AddPriors(problem);
  AddCameraPriors();
  HoldCameras(problem);
}

void BundleSolver::AddImages(const BundleProblem& problem) {
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    const BundleImage& image = problem.images[i];
    CameraState& camera = cameras_[static_cast<std::size_t>(image.camera)];
    q_W_B_.push_back(image.T_W_B.q);
    references_[i] = {image.T_W_B.R(),
                      camera.q_B_C.toRotationMatrix(),
                      image.velocity_W,
                      image.angular_velocity_B,
                      &camera.block};
    std::copy_n(image.T_W_B.t.data(), 3, bodies_[i].begin() + 3);
    problem_->AddParameterBlock(bodies_[i].data(), 6);
  }
  for (CameraState& camera : cameras_) {
    problem_->AddParameterBlock(camera.extrinsics.data(), 6);
    problem_->AddParameterBlock(&camera.time_offset_s, 1);
    problem_->AddParameterBlock(camera.projection.data(), camera.block.projection_size());
    problem_->AddParameterBlock(camera.distortion.data(), camera.block.distortion_size());
  }
}

void BundleSolver::AddObservations(const BundleProblem& problem) {
  for (std::size_t p = 0; p < point_indices_.size(); ++p) {
    const BundlePoint& point = problem.points[static_cast<std::size_t>(point_indices_[p])];
    points_[p] = point.p_W;
    problem_->AddParameterBlock(points_[p].data(), 3);
    for (const BundleObservation& o : point.observations) {
      const auto i = static_cast<std::size_t>(o.image);
      const BundleImage& image = problem.images[i];
      CameraState& camera = cameras_[static_cast<std::size_t>(image.camera)];
      const Eigen::Vector2d pixel =
          image.keypoints[static_cast<std::size_t>(o.keypoint)].cast<double>();
      auto error = std::make_unique<ReprojectionError>(references_[i], pixel, options_.pixel_sigma);
      problem_->AddResidualBlock(error.release(),
                                 &loss_,
                                 bodies_[i].data(),
                                 points_[p].data(),
                                 camera.extrinsics.data(),
                                 &camera.time_offset_s,
                                 camera.projection.data(),
                                 camera.distortion.data());
    }
  }
}

void BundleSolver::AddPriors(const BundleProblem& problem) {
  const auto body = [this](int image) { return bodies_[static_cast<std::size_t>(image)].data(); };
  const auto q = [this](int image) { return q_W_B_[static_cast<std::size_t>(image)]; };
  for (const RelativePosePrior& prior : problem.relative_priors) {
    problem_->AddResidualBlock(RelativePoseError::Create({prior, q(prior.from), q(prior.to)}),
                               &prior_loss_,
                               body(prior.from),
                               body(prior.to));
  }
  for (const TiltPrior& prior : problem.tilt_priors) {
    problem_->AddResidualBlock(
        TiltError::Create({prior, q(prior.image)}), nullptr, body(prior.image));
  }
  for (const PosePrior& prior : problem.pose_priors) {
    problem_->AddResidualBlock(
        PoseError::Create({prior, q(prior.image)}), &prior_loss_, body(prior.image));
  }
  if (problem.pose_priors.empty()) {
    problem_->SetParameterBlockConstant(bodies_.front().data());
  }
}

void BundleSolver::AddCameraPriors() {
  const BundleCameraSigmas& s = options_.camera_sigmas;
  for (CameraState& camera : cameras_) {
    if (options_.refine.extrinsics) {
      const double turn = s.extrinsic_deg * kDegree;
      AddNormalPrior({turn, turn, turn, s.extrinsic_m, s.extrinsic_m, s.extrinsic_m},
                     camera.extrinsics.data(),
                     problem_.get());
    }
    if (options_.refine.time_offset) {
      AddNormalPrior({s.time_offset_s}, &camera.time_offset_s, problem_.get());
    }
    if (options_.refine.intrinsics) {
      // [xi,] focal lengths, principal point
      std::vector<double> sigmas(camera.projection.size(), s.focal);
      const std::size_t focal = sigmas.size() - 4;
      sigmas[focal] = s.focal * camera.projection[focal];
      sigmas[focal + 1] = s.focal * camera.projection[focal + 1];
      sigmas[focal + 2] = sigmas[focal + 3] = s.centre_px;
      AddNormalPrior(sigmas, camera.projection.data(), problem_.get());
    }
    if (options_.refine.distortion) {
      AddNormalPrior(std::vector<double>(camera.distortion.size(), s.distortion),
                     camera.distortion.data(),
                     problem_.get());
    }
  }
}

void BundleSolver::HoldCameras(const BundleProblem& problem) {
  std::vector<bool> is_used(cameras_.size(), false);
  for (const BundleImage& image : problem.images) {
    is_used[static_cast<std::size_t>(image.camera)] = true;
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    CameraState& camera = cameras_[i];
    const auto hold = [&](bool is_refined, double* block) {
      if (!is_refined || !is_used[i]) {
        problem_->SetParameterBlockConstant(block);
      }
    };
    hold(options_.refine.extrinsics, camera.extrinsics.data());
    hold(options_.refine.time_offset, &camera.time_offset_s);
    hold(options_.refine.intrinsics, camera.projection.data());
    hold(options_.refine.distortion, camera.distortion.data());
  }
}

BundleSolver::Report BundleSolver::Solve(const std::function<bool(double share)>& goes_on) {
  // The damping keeps the whole in its place. Held by one image, all others would have to follow
  // where that one is wrong, which conjugate gradients do slowly.
  problem_->SetParameterBlockVariable(bodies_.front().data());
  ceres::Solver::Options solver;
  // Every image sees points of a hundred others: a factor of the reduced system is as good as
  // dense, and even the system takes longer to build than conjugate gradients take without it.
  solver.linear_solver_type = ceres::ITERATIVE_SCHUR;
  solver.preconditioner_type = ceres::SCHUR_JACOBI;
  solver.num_threads = 1;
  solver.max_num_iterations = options_.max_iterations;
  solver.function_tolerance = options_.tolerance;
  solver.logging_type = ceres::SILENT;
  solver.linear_solver_ordering.reset(new ceres::ParameterBlockOrdering);
  for (Eigen::Vector3d& point : points_) {
    solver.linear_solver_ordering->AddElementToGroup(point.data(), 0);
  }
  // Within a group blocks are ordered by their addresses, which for cameras' are any.
  int group = 1;
  for (std::array<double, 6>& body : bodies_) {
    solver.linear_solver_ordering->AddElementToGroup(body.data(), group);
  }
  for (CameraState& camera : cameras_) {
    for (double* block : {camera.extrinsics.data(),
                          &camera.time_offset_s,
                          camera.projection.data(),
                          camera.distortion.data()}) {
      solver.linear_solver_ordering->AddElementToGroup(block, ++group);
    }
  }
  StopOnRequest stop(options_.max_iterations, goes_on);
  solver.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, problem_.get(), &summary);
  return {summary.IsSolutionUsable(),
          summary.termination_type == ceres::USER_FAILURE,
          static_cast<int>(summary.iterations.size()) - 1};
}

void BundleSolver::Store(BundleProblem* problem) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const std::array<double, 6>& b = bodies_[i];
    problem->images[i].T_W_B = {(ExpSo3({b[0], b[1], b[2]}) * q_W_B_[i]).normalized(),
                                {b[3], b[4], b[5]}};
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    problem->points[static_cast<std::size_t>(point_indices_[i])].p_W = points_[i];
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const CameraState& state = cameras_[i];
    const std::array<double, 6>& e = state.extrinsics;
    BundleCamera& camera = problem->cameras[i];
    if (options_.refine.Any()) {
      camera.T_B_C = {(ExpSo3({e[0], e[1], e[2]}) * state.q_B_C).normalized(), {e[3], e[4], e[5]}};
      camera.time_offset_s = state.time_offset_s;
      camera.camera = state.block.Make(state.projection.data(), state.distortion.data());
      DEJA_VIEW_CHECK(camera.camera != nullptr);
    }
  }
}

BundleSolver::Linearisation BundleSolver::Linearise() {
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.num_threads = 1;
  for (std::array<double, 6>& body : bodies_) {
    evaluate.parameter_blocks.push_back(body.data());
  }
  const auto add = [&](double* block) {
    if (!problem_->IsParameterBlockConstant(block)) {
      evaluate.parameter_blocks.push_back(block);
    }
  };
  for (CameraState& camera : cameras_) {
    add(camera.extrinsics.data());
    add(&camera.time_offset_s);
    add(camera.projection.data());
    add(camera.distortion.data());
  }
  Linearisation result;
  for (double* block : evaluate.parameter_blocks) {
    result.first_point += problem_->ParameterBlockSize(block);
  }
  for (Eigen::Vector3d& point : points_) {
    evaluate.parameter_blocks.push_back(point.data());
  }
  ceres::CRSMatrix crs;
  problem_->Evaluate(evaluate, nullptr, nullptr, nullptr, &crs);
  result.J = Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>(
      crs.num_rows,
      crs.num_cols,
      static_cast<Eigen::Index>(crs.values.size()),
      crs.rows.data(),
      crs.cols.data(),
      crs.values.data());
  return result;
}

}  // namespace deja_view::internal
