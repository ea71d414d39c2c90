#include "deja_view/verification/loop_verifier.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/hamming_matcher.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <utility>

#include "keypoint_grid.hpp"
#include <Eigen/Eigenvalues>

namespace deja_view {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr int kCellColumns = 8;
constexpr int kCellRows = 6;
constexpr float kGridCellPx = 32.0F;

using CellSet = std::bitset<kCellColumns * kCellRows>;

Eigen::Vector3d ToDouble(const Eigen::Vector3f& v) {
  return v.cast<double>();
}

/// Cell of the grid over the image that spread is counted on.
std::size_t CellOf(const Eigen::Vector2f& pixel, const Camera& camera) {
  const int x =
      std::clamp(static_cast<int>(pixel.x()) * kCellColumns / camera.width(), 0, kCellColumns - 1);
  const int y =
      std::clamp(static_cast<int>(pixel.y()) * kCellRows / camera.height(), 0, kCellRows - 1);
  return static_cast<std::size_t>(y * kCellColumns + x);
}

}  // namespace

std::size_t KeyframeFeatures::MemoryBytes() const {
  const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v.front()); };
  return bytes(keypoints) + bytes(descriptors) + bytes(points_B) + bytes(point_pixels) +
         bytes(point_depth_sigmas) + bytes(point_ids) + bytes(point_descriptors);
}

std::vector<std::string> LoopVerifierOptions::Validate() const {
  std::vector<std::string> errors;
  const auto require = [&](bool ok, const char* text) {
    if (!ok) {
      errors.emplace_back(text);
    }
  };
  require(max_distance > 0 && max_distance <= 256, "max_distance must be in 1..256");
  require(max_ratio > 0 && max_ratio <= 1, "max_ratio must be in (0, 1]");
  require(min_matches >= 3, "min_matches must be at least 3");
  require(min_ransac_inliers >= 3, "min_ransac_inliers must be at least 3");
  require(final_radius_px > 0, "final_radius_px must be positive");
  require(guided_radius_px > 0, "guided_radius_px must be positive");
  require(guided_max_distance > 0 && guided_max_distance <= 256,
          "guided_max_distance must be in 1..256");
  require(min_inliers >= 4, "min_inliers must be at least 4");
  require(min_inlier_ratio >= 0 && min_inlier_ratio <= 1, "min_inlier_ratio must be in [0, 1]");
  require(min_cells >= 1 && min_cells <= kCellColumns * kCellRows, "min_cells must be in 1..48");
  require(max_distance_m > 0, "max_distance_m must be positive");
  require(max_yaw_deg > 0, "max_yaw_deg must be positive");
  require(max_gravity_deg > 0, "max_gravity_deg must be positive");
  require(max_sigma_m > 0, "max_sigma_m must be positive");
  require(pose.inlier_threshold_px > 0, "pose.inlier_threshold_px must be positive");
  require(pose.ransac_threshold_px > 0, "pose.ransac_threshold_px must be positive");
  require(pose.pixel_sigma > 0, "pose.pixel_sigma must be positive");
  require(pose.tilt_sigma_deg > 0, "pose.tilt_sigma_deg must be positive");
  require(pose.max_iterations > 0, "pose.max_iterations must be positive");
  require(pose.confidence > 0 && pose.confidence < 1, "pose.confidence must be in (0, 1)");
  return errors;
}

/// Point `point` of one keyframe seen as keypoint `keypoint` of the other.
struct LoopVerifier::Match {
  int point = -1;
  int keypoint = -1;
};

struct LoopVerifier::Problem {
  std::vector<PointObservation> observations;
  std::vector<Match> matches;  ///< per observation
};

LoopVerifier::LoopVerifier(const LoopVerifierOptions& options, std::shared_ptr<const Camera> camera)
    : options_(options), camera_(std::move(camera)) {
  DEJA_VIEW_CHECK(camera_ != nullptr);
}

std::vector<LoopVerifier::Match> LoopVerifier::MatchAll(const KeyframeFeatures& points,
                                                        const KeyframeFeatures& image) const {
  std::vector<Match> matches;
  const std::vector<HammingMatch> nearest =
      MatchHamming(points.point_descriptors, image.descriptors);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const HammingMatch& n = nearest[i];
    if (n.best >= 0 && n.best_distance <= options_.max_distance &&
        n.best_distance <= options_.max_ratio * n.second_distance) {
      matches.push_back({static_cast<int>(i), n.best});
    }
  }
  return matches;
}

std::vector<LoopVerifier::Match> LoopVerifier::MatchGuided(const KeyframeFeatures& points,
                                                           const KeyframeFeatures& image,
                                                           const Rigid3& T_image_points,
                                                           double radius_px,
                                                           int* visible) const {
  const KeypointGrid grid(image.keypoints, camera_->width(), camera_->height(), kGridCellPx);
  const Rigid3 T_C_points = image.T_B_C.Inverse() * T_image_points;
  std::vector<Match> matches;
  for (std::size_t i = 0; i < points.points_B.size(); ++i) {
    const auto pixel = camera_->Project(T_C_points * ToDouble(points.points_B[i]));
    if (!pixel || !camera_->IsInImage(*pixel)) {
      continue;
    }
    ++*visible;
    Match best{static_cast<int>(i), -1};
    int best_distance = options_.guided_max_distance + 1;
    grid.ForEachNear(pixel->cast<float>(), static_cast<float>(radius_px), [&](int keypoint) {
      const int distance = HammingDistance(points.point_descriptors[i],
                                           image.descriptors[static_cast<std::size_t>(keypoint)]);
      if (distance < best_distance) {
        best_distance = distance;
        best.keypoint = keypoint;
      }
    });
    if (best.keypoint >= 0) {
      matches.push_back(best);
    }
  }
  return matches;
}

void LoopVerifier::AddObservations(const std::vector<Match>& matches,
                                   const KeyframeFeatures& points,
                                   const KeyframeFeatures& image,
                                   bool is_reverse,
                                   Problem* problem) const {
  for (const Match& match : matches) {
    PointObservation o;
    o.point = ToDouble(points.points_B[static_cast<std::size_t>(match.point)]);
    const Eigen::Vector3d from_camera = o.point - points.T_B_C.t;
    o.sight = from_camera.normalized();
    o.depth_sigma = points.point_depth_sigmas[static_cast<std::size_t>(match.point)];
    const Eigen::Vector2f& pixel = image.keypoints[static_cast<std::size_t>(match.keypoint)];
    o.bearing = image.T_B_C.q * camera_->Unproject(pixel.cast<double>());
    o.centre = image.T_B_C.t;
    o.is_reverse = is_reverse;
    problem->observations.push_back(o);
    problem->matches.push_back(match);
  }
}

void LoopVerifier::MatchBothWays(const KeyframeFeatures& current,
                                 const KeyframeFeatures& old,
                                 const Rigid3& T_old_current,
                                 double radius_px,
                                 Problem* problem,
                                 int* visible) const {
  *problem = Problem{};
  *visible = 0;
  AddObservations(
      MatchGuided(current, old, T_old_current, radius_px, visible), current, old, false, problem);
  AddObservations(MatchGuided(old, current, T_old_current.Inverse(), radius_px, visible),
                  old,
                  current,
                  true,
                  problem);
}

std::optional<Rigid3> LoopVerifier::FirstPose(const KeyframeFeatures& current,
                                              const KeyframeFeatures& old,
                                              const GravityPair& gravity,
                                              Verification* v) const {
  Problem problem;
  AddObservations(MatchAll(current, old), current, old, false, &problem);
  AddObservations(MatchAll(old, current), old, current, true, &problem);
  v->matches = static_cast<int>(problem.observations.size());
  if (v->matches < options_.min_matches) {
    v->reason = RejectReason::kTooFewMatches;
    return std::nullopt;
  }
  const double focal = camera_->FocalLength();
  const RansacResult ransac =
      EstimateRelativePose(problem.observations, gravity, focal, options_.pose);
  v->ransac_inliers = static_cast<int>(ransac.inliers.size());
  if (v->ransac_inliers < options_.min_ransac_inliers) {
    v->reason = RejectReason::kTooFewInliers;
    return std::nullopt;
  }
  std::vector<PointObservation> supported;
  for (const int i : ransac.inliers) {
    supported.push_back(problem.observations[static_cast<std::size_t>(i)]);
  }
  return RefineRelativePose(ransac.T_O_U, supported, gravity, true, focal, options_.pose).T_O_U;
}

void LoopVerifier::Summarise(const KeyframeFeatures& current,
                             const KeyframeFeatures& old,
                             const Problem& problem,
                             const RefinedPose& pose,
                             Verification* v) const {
  v->T_Bold_Bcurrent = pose.T_O_U;
  v->covariance = pose.covariance;
  v->rmse_px = pose.rmse_px;
  v->inliers = static_cast<int>(pose.inliers.size());
  CellSet old_cells;
  CellSet current_cells;
  for (const int i : pose.inliers) {
    const Match& match = problem.matches[static_cast<std::size_t>(i)];
    const bool is_reverse = problem.observations[static_cast<std::size_t>(i)].is_reverse;
    const KeyframeFeatures& points = is_reverse ? old : current;
    const KeyframeFeatures& image = is_reverse ? current : old;
    (is_reverse ? old_cells : current_cells)
        .set(CellOf(points.point_pixels[static_cast<std::size_t>(match.point)], *camera_));
    (is_reverse ? current_cells : old_cells)
        .set(CellOf(image.keypoints[static_cast<std::size_t>(match.keypoint)], *camera_));
    if (!is_reverse) {
      v->point_matches.push_back({match.point, match.keypoint});
    }
  }
  v->cells = static_cast<int>(std::min(old_cells.count(), current_cells.count()));
}

Verification LoopVerifier::Verify(const KeyframeFeatures& current,
                                  const Eigen::Quaterniond& q_W_Bcurrent,
                                  const KeyframeFeatures& old,
                                  const Eigen::Quaterniond& q_W_Bold) const {
  Verification v;
  const GravityPair gravity{LevelRotation(q_W_Bold), LevelRotation(q_W_Bcurrent)};
  const auto refine = [&](const Rigid3& start, const Problem& problem, bool use_gravity) {
    return RefineRelativePose(
        start, problem.observations, gravity, use_gravity, camera_->FocalLength(), options_.pose);
  };
  const std::optional<Rigid3> first = FirstPose(current, old, gravity, &v);
  if (!first) {
    return v;
  }
  // Twice, the second time closer around the better pose: the wide window lets wrong neighbours in.
  Problem guided;
  Rigid3 T_old_current = *first;
  for (const double radius_px : {options_.guided_radius_px, options_.final_radius_px}) {
    MatchBothWays(current, old, T_old_current, radius_px, &guided, &v.visible);
    v.guided = static_cast<int>(guided.observations.size());
    if (v.guided < options_.min_ransac_inliers) {
      v.reason = RejectReason::kTooFewInliers;
      return v;
    }
    T_old_current = refine(T_old_current, guided, true).T_O_U;
  }
  v.gravity_disagreement = GravityDisagreement(refine(T_old_current, guided, false).T_O_U, gravity);
  Summarise(current, old, guided, refine(T_old_current, guided, true), &v);
  v.reason = Gate(v);
  return v;
}

RejectReason LoopVerifier::Gate(const Verification& v) const {
  if (v.inliers < options_.min_inliers) {
    return RejectReason::kTooFewInliers;
  }
  if (v.inliers < options_.min_inlier_ratio * v.visible) {
    return RejectReason::kLowInlierRatio;
  }
  if (v.cells < options_.min_cells) {
    return RejectReason::kPoorSpread;
  }
  if (v.T_Bold_Bcurrent.t.norm() > options_.max_distance_m) {
    return RejectReason::kTooFar;
  }
  if (RotationAngle(v.T_Bold_Bcurrent.q) > options_.max_yaw_deg * kDegree) {
    return RejectReason::kTooMuchYaw;
  }
  if (v.gravity_disagreement > options_.max_gravity_deg * kDegree) {
    return RejectReason::kGravity;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(v.covariance.topLeftCorner<3, 3>(),
                                                             Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues().maxCoeff() < options_.max_sigma_m * options_.max_sigma_m)) {
    return RejectReason::kUncertain;
  }
  return RejectReason::kNone;
}

}  // namespace deja_view
