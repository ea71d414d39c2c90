#include "deja_view/base/check.hpp"
#include "deja_view/bundle/bundle_adjuster.hpp"

#include <numeric>
#include <vector>

#include "bundle_solver.hpp"
#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

namespace deja_view {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Information of the first columns with the points marginalised (Schur complement).
Sparse ReducedInformation(const internal::BundleSolver::Linearisation& l) {
  const Eigen::Index cameras = l.first_point;
  const Eigen::Index points = l.J.cols() - cameras;
  const Sparse J_cameras = l.J.leftCols(cameras);
  const Sparse J_points = l.J.rightCols(points);
  const Sparse H_points = J_points.transpose() * J_points;
  std::vector<Eigen::Triplet<double>> inverse;
  for (Eigen::Index p = 0; p < points; p += 3) {
    const Eigen::Matrix3d block =
        Eigen::Matrix3d(H_points.block(p, p, 3, 3)).ldlt().solve(Eigen::Matrix3d::Identity());
    for (Eigen::Index i = 0; i < 9; ++i) {
      inverse.emplace_back(p + i / 3, p + i % 3, block(i / 3, i % 3));
    }
  }
  Sparse H_inverse(points, points);
  H_inverse.setFromTriplets(inverse.begin(), inverse.end());
  const Sparse W = J_points.transpose() * J_cameras;
  return Sparse(J_cameras.transpose() * J_cameras) - Sparse(W.transpose() * Sparse(H_inverse * W));
}

}  // namespace

std::vector<Eigen::Matrix<double, 6, 6>> PoseCovariances(const BundleOptions& options,
                                                         const BundleProblem& problem,
                                                         const std::vector<int>& images) {
  std::vector<int> points(problem.points.size());
  std::iota(points.begin(), points.end(), 0);
  internal::BundleSolver solver(options, problem, points);
  Sparse information = ReducedInformation(solver.Linearise());
  // What nothing determines, as the held first image, gets a variance of nearly nothing known.
  constexpr double kFloor = 1e-9;
  for (Eigen::Index i = 0; i < information.rows(); ++i) {
    information.coeffRef(i, i) += kFloor;
  }
  const Eigen::SimplicialLDLT<Sparse> factor(information);
  DEJA_VIEW_CHECK(factor.info() == Eigen::Success);
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;
  for (const int image : images) {
    DEJA_VIEW_CHECK(image >= 0 && static_cast<std::size_t>(image) < problem.images.size());
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(information.rows(), 6);
    unit.middleRows(6 * image, 6).setIdentity();
    const Eigen::Matrix<double, 6, 6> of_block = factor.solve(unit).middleRows(6 * image, 6);
    // The solver's order is (w, t).
    Eigen::Matrix<double, 6, 6> covariance;
    covariance << of_block.bottomRightCorner<3, 3>(), of_block.bottomLeftCorner<3, 3>(),
        of_block.topRightCorner<3, 3>(), of_block.topLeftCorner<3, 3>();
    covariances.push_back(covariance);
  }
  return covariances;
}

}  // namespace deja_view
