#include "deja_view/geometry/trajectory_alignment.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include <Eigen/Eigenvalues>

namespace deja_view {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Similarity3 Fit(const Points& p_A, const Points& p_B, AlignmentFreedom freedom) {
  if (freedom == AlignmentFreedom::kYaw) {
    return {1.0, AlignYaw(p_A, p_B)};
  }
  return AlignPoints(p_A, p_B, freedom == AlignmentFreedom::kSimilarity);
}

std::vector<std::size_t> FindInliers(const Similarity3& A_B,
                                     const Points& p_A,
                                     const Points& p_B,
                                     double distance) {
  std::vector<std::size_t> inliers;
  for (std::size_t i = 0; i < p_A.size(); ++i) {
    if ((A_B * p_B[i] - p_A[i]).norm() <= distance) {
      inliers.push_back(i);
    }
  }
  return inliers;
}

Points Pick(const Points& points, const std::vector<std::size_t>& indices) {
  Points picked;
  for (const std::size_t i : indices) {
    picked.push_back(points[i]);
  }
  return picked;
}

Similarity3 Sample(const Points& p_A, const Points& p_B, const AlignmentOptions& options) {
  constexpr int kSamples = 300;
  std::mt19937_64 random(options.seed);
  Similarity3 best = Fit(p_A, p_B, options.freedom);
  std::size_t most = FindInliers(best, p_A, p_B, options.inlier_distance_m).size();
  for (int sample = 0; sample < kSamples && most < p_A.size(); ++sample) {
    std::vector<std::size_t> indices;
    for (int i = 0; i < 3; ++i) {
      indices.push_back(random() % p_A.size());
    }
    const Similarity3 A_B = Fit(Pick(p_A, indices), Pick(p_B, indices), options.freedom);
    if (!A_B.T_A_B.IsFinite() || !std::isfinite(A_B.scale) || !(A_B.scale > 0)) {
      continue;
    }
    const std::size_t count = FindInliers(A_B, p_A, p_B, options.inlier_distance_m).size();
    if (count > most) {
      most = count;
      best = A_B;
    }
  }
  return best;
}

double MedianRotation(const std::vector<Rigid3>& T_A_X,
                      const std::vector<Rigid3>& T_B_X,
                      const Eigen::Quaterniond& q_A_B) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < T_A_X.size(); ++i) {
    angles.push_back(RotationAngle(T_A_X[i].q.conjugate() * (q_A_B * T_B_X[i].q)));
  }
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle;
}

// True when the points leave a rotation open: they have extent along one direction at most or,
// with yaw alone, none across the vertical.
bool IsRotationOpen(const Points& points, AlignmentFreedom freedom) {
  constexpr double kMinShare = 0.01;
  const Eigen::Vector3d mean = MeanPoint(points);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    scatter += (p - mean) * (p - mean).transpose();
  }
  if (freedom == AlignmentFreedom::kYaw) {
    return scatter(0, 0) + scatter(1, 1) <= kMinShare * kMinShare * scatter.trace();
  }
  // Eigenvalues come in increasing order.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return spread[1] <= kMinShare * spread[2];
}

struct Pairs {
  std::vector<Rigid3> T_A_X;
  std::vector<Rigid3> T_B_X;
};

Pairs FindPairs(const Trajectory& T_A_X, const Trajectory& T_B_X, std::int64_t max_gap_ns) {
  Pairs pairs;
  const Trajectory& sparse = T_A_X.size() < T_B_X.size() ? T_A_X : T_B_X;
  for (const std::int64_t stamp_ns : sparse.stamps_ns) {
    const std::optional<Rigid3> T_A = T_A_X.At(stamp_ns, max_gap_ns);
    const std::optional<Rigid3> T_B = T_B_X.At(stamp_ns, max_gap_ns);
    if (T_A && T_B) {
      pairs.T_A_X.push_back(*T_A);
      pairs.T_B_X.push_back(*T_B);
    }
  }
  return pairs;
}

Points Positions(const std::vector<Rigid3>& poses) {
  Points points;
  for (const Rigid3& pose : poses) {
    points.push_back(pose.t);
  }
  return points;
}

// Empty: none.
std::string ObstacleOf(const Pairs& pairs, AlignmentFreedom freedom) {
  constexpr std::size_t kMinPairs = 10;
  if (pairs.T_A_X.size() < kMinPairs) {
    return fmt::format(
        "{} poses have a common stamp: expected at least {}", pairs.T_A_X.size(), kMinPairs);
  }
  for (const std::vector<Rigid3>& poses : {pairs.T_A_X, pairs.T_B_X}) {
    if (IsRotationOpen(Positions(poses), freedom)) {
      return "the positions lie on one line, which leaves the alignment open";
    }
  }
  return "";
}

}  // namespace

std::string RobustAlignment::Summary() const {
  return fmt::format(
      "RMSE {:.3f} m over {:.1f} % of {} poses, largest {:.2f} m, orientation {:.2f} deg, "
      "scale {:.5g}",
      rmse_m,
      100 * inlier_share,
      pairs,
      max_m,
      ToDegrees(rotation_rad),
      A_B.scale);
}

RobustAlignment AlignPointsRobustly(const Points& p_A,
                                    const Points& p_B,
                                    const AlignmentOptions& options) {
  DEJA_VIEW_CHECK_OP(p_A.size(), ==, p_B.size());
  DEJA_VIEW_CHECK_OP(p_A.size(), >=, 3U);
  constexpr int kRefinements = 10;
  constexpr std::size_t kMinInliers = 3;
  RobustAlignment result;
  result.A_B = Sample(p_A, p_B, options);
  std::vector<std::size_t> inliers = FindInliers(result.A_B, p_A, p_B, options.inlier_distance_m);
  for (int i = 0; i < kRefinements && inliers.size() >= kMinInliers; ++i) {
    const Similarity3 refined = Fit(Pick(p_A, inliers), Pick(p_B, inliers), options.freedom);
    auto next = FindInliers(refined, p_A, p_B, options.inlier_distance_m);
    if (next.size() < inliers.size()) {
      break;
    }
    result.A_B = refined;
    const bool has_settled = next == inliers;
    inliers = std::move(next);
    if (has_settled) {
      break;
    }
  }
  double sum = 0;
  for (const std::size_t i : inliers) {
    sum += (result.A_B * p_B[i] - p_A[i]).squaredNorm();
  }
  for (std::size_t i = 0; i < p_A.size(); ++i) {
    result.max_m = std::max(result.max_m, (result.A_B * p_B[i] - p_A[i]).norm());
  }
  result.pairs = p_A.size();
  result.inlier_share = static_cast<double>(inliers.size()) / static_cast<double>(p_A.size());
  result.rmse_m = inliers.empty() ? 0 : std::sqrt(sum / static_cast<double>(inliers.size()));
  return result;
}

std::string AlignmentObstacle(const Trajectory& T_A_X,
                              const Trajectory& T_B_X,
                              const AlignmentOptions& options) {
  return ObstacleOf(FindPairs(T_A_X, T_B_X, options.max_gap_ns), options.freedom);
}

RobustAlignment AlignTrajectories(const Trajectory& T_A_X,
                                  const Trajectory& T_B_X,
                                  const AlignmentOptions& options,
                                  const std::string& what) {
  const Pairs pairs = FindPairs(T_A_X, T_B_X, options.max_gap_ns);
  const std::string obstacle = ObstacleOf(pairs, options.freedom);
  if (!obstacle.empty()) {
    ThrowInputError("{}: {}", what, obstacle);
  }
  const Points p_A = Positions(pairs.T_A_X);
  const Points p_B = Positions(pairs.T_B_X);
  RobustAlignment result = AlignPointsRobustly(p_A, p_B, options);
  result.rotation_rad = MedianRotation(pairs.T_A_X, pairs.T_B_X, result.A_B.T_A_B.q);
  if (result.inlier_share < options.min_inlier_share || result.rmse_m > options.max_rmse_m ||
      result.rotation_rad > options.max_rotation_rad) {
    ThrowInputError(
        "{}: does not fit: {}; expected at most {} m over at least {:.0f} %, and {:.0f} deg",
        what,
        result.Summary(),
        options.max_rmse_m,
        100 * options.min_inlier_share,
        ToDegrees(options.max_rotation_rad));
  }
  return result;
}

Trajectory Transform(const Similarity3& A_B, const Trajectory& T_B_X) {
  Trajectory T_A_X;
  T_A_X.stamps_ns = T_B_X.stamps_ns;
  for (const Rigid3& pose : T_B_X.poses) {
    T_A_X.poses.push_back({(A_B.T_A_B.q * pose.q).normalized(), A_B * pose.t});
  }
  return T_A_X;
}

Trajectory Transform(const Trajectory& T_A_X, const Rigid3& T_X_Y) {
  Trajectory T_A_Y;
  T_A_Y.stamps_ns = T_A_X.stamps_ns;
  for (const Rigid3& pose : T_A_X.poses) {
    T_A_Y.poses.push_back(pose * T_X_Y);
  }
  return T_A_Y;
}

}  // namespace deja_view
