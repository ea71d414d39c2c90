#include "deja_view/verification/relative_pose.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <Eigen/Cholesky>

namespace deja_view {
namespace {

/// An observation in level frames, for the two-point solver: points of `is_reverse` observations
/// solve for the inverse transform.
GravityAlignedPoint ToLevel(const PointObservation& o, const GravityPair& gravity) {
  const Eigen::Quaterniond& q_point = o.is_reverse ? gravity.q_G_O : gravity.q_G_U;
  const Eigen::Quaterniond& q_sight = o.is_reverse ? gravity.q_G_U : gravity.q_G_O;
  return {q_point * o.point, q_sight * o.bearing, q_sight * o.centre};
}

/// Squared angular error in units of the tangent: |v x f|^2 / (v.f)^2, or infinity behind the
/// camera.
double SquaredTangent(const Rigid3& T, const Eigen::Vector3d& p, const GravityAlignedPoint& o) {
  const Eigen::Vector3d v = T * p - o.centre;
  const double along = v.dot(o.bearing);
  if (along <= 0) {
    return std::numeric_limits<double>::infinity();
  }
  return (v.squaredNorm() - along * along) / (along * along);
}

int IterationsFor(double inlier_ratio, const RelativePoseOptions& options) {
  const double good = std::max(1e-9, inlier_ratio * inlier_ratio);
  if (good >= 1.0 - 1e-12) {
    return 1;
  }
  const double needed = std::log(1.0 - options.confidence) / std::log(1.0 - good);
  return static_cast<int>(std::min<double>(options.max_iterations, std::ceil(needed)));
}

/// Two distinct indices below `count`, from a small fixed generator (std distributions differ
/// between standard libraries).
class PairSampler {
 public:
  PairSampler(std::uint32_t seed, std::uint32_t count) : rng_(seed), count_(count) {}

  std::pair<std::uint32_t, std::uint32_t> Next() {
    const std::uint32_t a = Below(count_);
    const std::uint32_t b = Below(count_ - 1);
    return {a, b < a ? b : b + 1};
  }

 private:
  std::uint32_t Below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(rng_()) * n) >> 32U);
  }

  std::mt19937 rng_;
  std::uint32_t count_;
};

struct LevelProblem {
  std::vector<GravityAlignedPoint> points;
  std::vector<bool> is_reverse;
};

/// Truncated squared error over all observations (MSAC); smaller is better. Where it reaches
/// `limit`, the rest is not looked at.
double Cost(const LevelProblem& problem, const Rigid3& T, double threshold, double limit) {
  const Rigid3 inverse = T.Inverse();
  double cost = 0;
  for (std::size_t i = 0; i < problem.points.size() && cost < limit; ++i) {
    const GravityAlignedPoint& o = problem.points[i];
    cost += std::min(threshold, SquaredTangent(problem.is_reverse[i] ? inverse : T, o.point, o));
  }
  return cost;
}

std::vector<int> Inliers(const LevelProblem& problem, const Rigid3& T, double threshold) {
  const Rigid3 inverse = T.Inverse();
  std::vector<int> inliers;
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    const GravityAlignedPoint& o = problem.points[i];
    if (SquaredTangent(problem.is_reverse[i] ? inverse : T, o.point, o) < threshold) {
      inliers.push_back(static_cast<int>(i));
    }
  }
  return inliers;
}

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

/// An orthonormal basis of the plane perpendicular to a bearing.
struct TangentBasis {
  explicit TangentBasis(const Eigen::Vector3d& f) : x(f.unitOrthogonal()), y(f.cross(x)) {}

  Eigen::Vector3d x;
  Eigen::Vector3d y;
};

struct Linearised {
  Eigen::Vector2d r;            ///< whitened residual
  Matrix26 J;                   ///< d r / d (t, w)
  double reprojection_px2 = 0;  ///< squared error before whitening
  bool is_valid = false;
};

/// One observation's residual in pixels on the tangent plane of its bearing, whitened by pixel and
/// depth noise; `J` in (dt, w) of T = (t + dt, Exp(w) R).
Linearised Linearise(const PointObservation& o,
                     const TangentBasis& basis,
                     const Eigen::Matrix3d& R,
                     const Eigen::Vector3d& t,
                     double focal_px,
                     const RelativePoseOptions& options) {
  Linearised result;
  const Eigen::Vector3d lever = o.is_reverse ? (o.point - t).eval() : (R * o.point).eval();
  const Eigen::Vector3d v =
      o.is_reverse ? (R.transpose() * lever - o.centre).eval() : (lever + t - o.centre).eval();
  const double norm = v.norm();
  const Eigen::Vector3d direction = v / norm;
  if (norm < 1e-6 || direction.dot(o.bearing) <= 0.2) {
    return result;
  }
  const Eigen::Vector2d along(basis.x.dot(direction), basis.y.dot(direction));
  const Eigen::Vector2d r = focal_px * along;
  result.reprojection_px2 = r.squaredNorm();
  // d r / d v, its rows as columns: in the observing frame, then in O's.
  Eigen::Matrix<double, 3, 2> to_pixels;
  to_pixels.col(0) = focal_px / norm * (basis.x - along.x() * direction);
  to_pixels.col(1) = focal_px / norm * (basis.y - along.y() * direction);
  if (o.is_reverse) {
    to_pixels = (R * to_pixels).eval();
  }
  // Depth noise moves the point along its ray: S = sigma^2 I + u u^T, whose inverse root is
  // (I - u u^T / (s (s + sigma))) / sigma with s^2 = sigma^2 + u^T u.
  const Eigen::Vector3d sight = o.is_reverse ? o.sight : (R * o.sight).eval();
  const Eigen::Vector2d u = o.depth_sigma * to_pixels.transpose() * sight;
  const double sigma = options.pixel_sigma;
  const double s = std::sqrt(sigma * sigma + u.squaredNorm());
  const Eigen::Matrix2d whitening =
      (Eigen::Matrix2d::Identity() - u * u.transpose() / (s * (s + sigma))) / sigma;
  result.r = whitening * r;
  const Eigen::Matrix<double, 3, 2> rows =
      (o.is_reverse ? -1.0 : 1.0) * to_pixels * whitening.transpose();
  result.J.leftCols<3>() = rows.transpose();
  result.J.row(0).tail<3>() = lever.cross(rows.col(0));
  result.J.row(1).tail<3>() = lever.cross(rows.col(1));
  result.is_valid = true;
  return result;
}

/// Roll and pitch residual [rad]: where O's vertical, carried to U by T_O_U, misses U's vertical.
Eigen::Vector3d TiltResidual(const Rigid3& T_O_U, const GravityPair& gravity) {
  const Eigen::Vector3d up_O = gravity.q_G_O.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up_U = gravity.q_G_U.conjugate() * Eigen::Vector3d::UnitZ();
  return up_O.cross(T_O_U.q * up_U);
}

struct NormalEquations {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double cost = 0;
};

constexpr double kCauchyScale = 1.5;  // in units of the whitened residual's sigma

NormalEquations Accumulate(const Rigid3& T_O_U,
                           const std::vector<PointObservation>& observations,
                           const std::vector<TangentBasis>& bases,
                           const GravityPair& gravity,
                           bool use_gravity,
                           double focal_px,
                           const RelativePoseOptions& options) {
  NormalEquations sum;
  const Eigen::Matrix3d R = T_O_U.R();
  constexpr double kScale2 = kCauchyScale * kCauchyScale;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Linearised l = Linearise(observations[i], bases[i], R, T_O_U.t, focal_px, options);
    if (!l.is_valid) {
      sum.cost += kScale2 * std::log1p(1e4);
      continue;
    }
    const double squared = l.r.squaredNorm();
    const double weight = 1.0 / (1.0 + squared / kScale2);
    sum.cost += kScale2 * std::log1p(squared / kScale2);
    sum.H.noalias() += weight * l.J.transpose() * l.J;
    sum.g.noalias() += weight * l.J.transpose() * l.r;
  }
  if (use_gravity) {
    const double sigma = ToRadians(options.tilt_sigma_deg);
    const Eigen::Vector3d up_O = gravity.q_G_O.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_U = T_O_U.q * (gravity.q_G_U.conjugate() * Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d r = TiltResidual(T_O_U, gravity) / sigma;
    // d(up_O x Exp(w) up_U) / dw = -[up_O]x [up_U]x
    const Eigen::Matrix3d J = -Skew(up_O) * Skew(up_U) / sigma;
    sum.H.bottomRightCorner<3, 3>() += J.transpose() * J;
    sum.g.tail<3>() += J.transpose() * r;
    sum.cost += r.squaredNorm();
  }
  return sum;
}

Rigid3 Retract(const Rigid3& T, const Vector6& step) {
  return {(ExpSo3(step.tail<3>()) * T.q).normalized(), T.t + step.head<3>()};
}

}  // namespace

std::vector<std::string> RelativePoseOptions::Validate() const {
  Requirements r;
  r.That(inlier_threshold_px > 0, "inlier_threshold_px", inlier_threshold_px, "more than 0");
  r.That(ransac_threshold_px > 0, "ransac_threshold_px", ransac_threshold_px, "more than 0");
  r.That(pixel_sigma > 0, "pixel_sigma", pixel_sigma, "more than 0");
  r.That(tilt_sigma_deg > 0, "tilt_sigma_deg", tilt_sigma_deg, "more than 0");
  r.That(max_iterations > 0, "max_iterations", max_iterations, "more than 0");
  r.That(confidence > 0 && confidence < 1, "confidence", confidence, "more than 0, less than 1");
  return r.errors();
}

Eigen::Quaterniond LevelRotation(const Eigen::Quaterniond& q_W_B) {
  const Eigen::Vector3d up_B = q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
  return Eigen::Quaterniond::FromTwoVectors(up_B, Eigen::Vector3d::UnitZ());
}

RansacResult EstimateRelativePose(const std::vector<PointObservation>& observations,
                                  const GravityPair& gravity,
                                  double focal_px,
                                  const RelativePoseOptions& options) {
  RansacResult result;
  if (observations.size() < 3) {
    return result;
  }
  LevelProblem problem;
  for (const PointObservation& o : observations) {
    problem.points.push_back(ToLevel(o, gravity));
    problem.is_reverse.push_back(o.is_reverse);
  }
  const double threshold = std::pow(options.ransac_threshold_px / focal_px, 2);
  PairSampler sampler(options.seed, static_cast<std::uint32_t>(observations.size()));
  double best_cost = threshold * static_cast<double>(observations.size());
  Rigid3 best;
  bool found = false;
  int needed = options.max_iterations;
  for (int iteration = 0; iteration < needed; ++iteration) {
    const auto [a, b] = sampler.Next();
    if (problem.is_reverse[a] != problem.is_reverse[b]) {
      continue;
    }
    for (const YawTransform& solution :
         SolveTwoPointGravityPose(problem.points[a], problem.points[b])) {
      const Rigid3 forward = solution.ToRigid3();
      const Rigid3 T = problem.is_reverse[a] ? forward.Inverse() : forward;
      const double cost = Cost(problem, T, threshold, best_cost);
      if (cost < best_cost) {
        best_cost = cost;
        best = T;
        found = true;
        const auto inliers = Inliers(problem, T, threshold).size();
        needed = IterationsFor(
            static_cast<double>(inliers) / static_cast<double>(observations.size()), options);
      }
    }
  }
  if (!found) {
    return result;
  }
  result.inliers = Inliers(problem, best, threshold);
  if (result.inliers.size() < 3) {
    result.inliers.clear();
  }
  const Rigid3 T_G_O{gravity.q_G_O, Eigen::Vector3d::Zero()};
  const Rigid3 T_G_U{gravity.q_G_U, Eigen::Vector3d::Zero()};
  result.T_O_U = T_G_O.Inverse() * best * T_G_U;
  return result;
}

RefinedPose RefineRelativePose(const Rigid3& T_O_U_initial,
                               const std::vector<PointObservation>& observations,
                               const GravityPair& gravity,
                               bool use_gravity,
                               double focal_px,
                               const RelativePoseOptions& options) {
  RefinedPose result;
  result.T_O_U = T_O_U_initial;
  std::vector<TangentBasis> bases;
  bases.reserve(observations.size());
  for (const PointObservation& o : observations) {
    bases.emplace_back(o.bearing);
  }
  const auto accumulate = [&](const Rigid3& T) {
    return Accumulate(T, observations, bases, gravity, use_gravity, focal_px, options);
  };
  NormalEquations current = accumulate(result.T_O_U);
  double damping = 1e-4;
  for (int i = 0; i < options.max_refinements; ++i) {
    Matrix6 H = current.H;
    H.diagonal() += damping * H.diagonal() + Vector6::Constant(1e-9);
    const Vector6 step = -H.ldlt().solve(current.g);
    const Rigid3 candidate = Retract(result.T_O_U, step);
    const NormalEquations next = accumulate(candidate);
    if (!(next.cost < current.cost)) {
      damping *= 10.0;
      if (damping > 1e3) {
        break;
      }
      continue;
    }
    const bool converged = current.cost - next.cost < 1e-6 * current.cost;
    damping = std::max(1e-7, damping * 0.2);
    result.T_O_U = candidate;
    current = next;
    if (converged) {
      break;
    }
  }

  double sum = 0;
  double whitened = 0;
  const double limit = options.inlier_threshold_px / options.pixel_sigma;
  const Eigen::Matrix3d R = result.T_O_U.R();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Linearised l = Linearise(observations[i], bases[i], R, result.T_O_U.t, focal_px, options);
    if (l.is_valid && l.r.squaredNorm() < limit * limit) {
      result.inliers.push_back(static_cast<int>(i));
      sum += l.reprojection_px2;
      whitened += l.r.squaredNorm();
    }
  }
  const auto count = static_cast<double>(result.inliers.size());
  result.rmse_px = count > 0 ? std::sqrt(sum / count) : 0.0;
  const double variance_factor = count > 3 ? std::max(1.0, whitened / (2.0 * count - 6.0)) : 1e6;
  Matrix6 H = current.H;
  H.diagonal().array() += 1e-9;
  result.covariance = variance_factor * H.ldlt().solve(Matrix6::Identity());
  return result;
}

double GravityDisagreement(const Rigid3& T_O_U, const GravityPair& gravity) {
  const Eigen::Vector3d up_O = gravity.q_G_O.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up_U = T_O_U.q * (gravity.q_G_U.conjugate() * Eigen::Vector3d::UnitZ());
  return std::atan2(up_O.cross(up_U).norm(), up_O.dot(up_U));
}

}  // namespace deja_view
