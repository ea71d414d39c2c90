#include "deja_view/verification/loop_verifier.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/hamming_matcher.hpp"
#include "deja_view/features/keypoint_grid.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <utility>

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
  require(rig.min_ransac_ratio >= 0 && rig.min_ransac_ratio <= 1,
          "rig.min_ransac_ratio must be in [0, 1]");
  require(rig.min_inliers >= 4, "rig.min_inliers must be at least 4");
  require(rig.min_inlier_ratio >= 0 && rig.min_inlier_ratio <= 1,
          "rig.min_inlier_ratio must be in [0, 1]");
  require(rig.min_cells >= 1 && rig.min_cells <= kCellColumns * kCellRows,
          "rig.min_cells must be in 1..48");
  require(rig.max_gravity_deg > 0, "rig.max_gravity_deg must be positive");
  require(rig.max_sigma_m > 0, "rig.max_sigma_m must be positive");
  require(pose.inlier_threshold_px > 0, "pose.inlier_threshold_px must be positive");
  require(pose.ransac_threshold_px > 0, "pose.ransac_threshold_px must be positive");
  require(pose.pixel_sigma > 0, "pose.pixel_sigma must be positive");
  require(pose.tilt_sigma_deg > 0, "pose.tilt_sigma_deg must be positive");
  require(pose.max_iterations > 0, "pose.max_iterations must be positive");
  require(pose.confidence > 0 && pose.confidence < 1, "pose.confidence must be in (0, 1)");
  return errors;
}

/// Points of one keyframe looked for in an image of the other; each with its camera.
struct LoopVerifier::Link {
  const KeyframeFeatures* points;
  const Camera* points_camera;
  const KeyframeFeatures* image;
  const Camera* image_camera;
  bool is_reverse;  ///< points of the old keyframe in the current image
};

/// Point `point` of a link's points seen as keypoint `keypoint` of its image.
struct LoopVerifier::Match {
  int point = -1;
  int keypoint = -1;
  std::size_t link = 0;
};

struct LoopVerifier::Problem {
  std::vector<PointObservation> observations;
  std::vector<Match> matches;              ///< per observation
  std::vector<std::vector<bool>> visible;  ///< per link: points that fall into the image
};

/// Two keyframes: the links between their cameras, the two real ones first.
struct LoopVerifier::Pair {
  std::vector<Link> links;
  GravityPair gravity;

  bool has_rig() const { return links.size() > 2; }
};

LoopVerifier::LoopVerifier(const LoopVerifierOptions& options, std::shared_ptr<const Camera> camera)
    : options_(options), camera_(std::move(camera)) {
  DEJA_VIEW_CHECK(camera_ != nullptr);
}

std::vector<LoopVerifier::Match> LoopVerifier::MatchAll(const Link& link) const {
  std::vector<Match> matches;
  const std::vector<HammingMatch> nearest =
      MatchHamming(link.points->point_descriptors, link.image->descriptors);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const HammingMatch& n = nearest[i];
    if (n.best >= 0 && n.best_distance <= options_.max_distance &&
        n.best_distance <= options_.max_ratio * n.second_distance) {
      matches.push_back({static_cast<int>(i), n.best});
    }
  }
  return matches;
}

std::vector<LoopVerifier::Match> LoopVerifier::MatchGuided(const Link& link,
                                                           const Rigid3& T_image_points,
                                                           double radius_px,
                                                           std::vector<bool>* visible) const {
  const KeyframeFeatures& points = *link.points;
  const KeyframeFeatures& image = *link.image;
  const Camera& camera = *link.image_camera;
  const KeypointGrid grid(image.keypoints, camera.width(), camera.height(), kGridCellPx);
  const Rigid3 T_C_points = image.T_B_C.Inverse() * T_image_points;
  std::vector<Match> matches;
  visible->assign(points.points_B.size(), false);
  for (std::size_t i = 0; i < points.points_B.size(); ++i) {
    const auto pixel = camera.Project(T_C_points * ToDouble(points.points_B[i]));
    if (!pixel || !camera.IsInImage(*pixel)) {
      continue;
    }
    (*visible)[i] = true;
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

void LoopVerifier::AddObservations(const Link& link,
                                   std::size_t index,
                                   const std::vector<Match>& matches,
                                   Problem* problem) const {
  const KeyframeFeatures& points = *link.points;
  const KeyframeFeatures& image = *link.image;
  for (const Match& match : matches) {
    PointObservation o;
    o.point = ToDouble(points.points_B[static_cast<std::size_t>(match.point)]);
    const Eigen::Vector3d from_camera = o.point - points.T_B_C.t;
    o.sight = from_camera.normalized();
    o.depth_sigma = points.point_depth_sigmas[static_cast<std::size_t>(match.point)];
    const Eigen::Vector2f& pixel = image.keypoints[static_cast<std::size_t>(match.keypoint)];
    o.bearing = image.T_B_C.q * link.image_camera->Unproject(pixel.cast<double>());
    o.centre = image.T_B_C.t;
    o.is_reverse = link.is_reverse;
    problem->observations.push_back(o);
    problem->matches.push_back({match.point, match.keypoint, index});
  }
}

LoopVerifier::Problem LoopVerifier::MatchAround(const Pair& pair,
                                                const Rigid3& T_old_current,
                                                double radius_px) const {
  Problem problem;
  problem.visible.resize(pair.links.size());
  const Rigid3 T_current_old = T_old_current.Inverse();
  for (std::size_t i = 0; i < pair.links.size(); ++i) {
    const Link& link = pair.links[i];
    const Rigid3& T_image_points = link.is_reverse ? T_current_old : T_old_current;
    AddObservations(
        link, i, MatchGuided(link, T_image_points, radius_px, &problem.visible[i]), &problem);
  }
  return problem;
}

RigGates LoopVerifier::GatesOf(const Pair& pair) const {
  return pair.has_rig() ? options_.rig
                        : RigGates{0.0,
                                   options_.min_inliers,
                                   options_.min_inlier_ratio,
                                   options_.min_cells,
                                   options_.max_gravity_deg,
                                   options_.max_sigma_m};
}

std::optional<Rigid3> LoopVerifier::FirstPose(const Pair& pair, Verification* v) const {
  Problem problem;
  for (std::size_t i = 0; i < pair.links.size(); ++i) {
    AddObservations(pair.links[i], i, MatchAll(pair.links[i]), &problem);
  }
  v->matches = static_cast<int>(problem.observations.size());
  if (v->matches < options_.min_matches) {
    v->reason = RejectReason::kTooFewMatches;
    return std::nullopt;
  }
  const double focal = camera_->FocalLength();
  const RansacResult ransac =
      EstimateRelativePose(problem.observations, pair.gravity, focal, options_.pose);
  v->ransac_inliers = static_cast<int>(ransac.inliers.size());
  if (v->ransac_inliers < options_.min_ransac_inliers ||
      v->ransac_inliers < GatesOf(pair).min_ransac_ratio * v->matches) {
    v->reason = RejectReason::kTooFewInliers;
    return std::nullopt;
  }
  std::vector<PointObservation> supported;
  for (const int i : ransac.inliers) {
    supported.push_back(problem.observations[static_cast<std::size_t>(i)]);
  }
  return RefineRelativePose(ransac.T_O_U, supported, pair.gravity, true, focal, options_.pose)
      .T_O_U;
}

void LoopVerifier::Summarise(const Pair& pair,
                             const Problem& problem,
                             const RefinedPose& pose,
                             Verification* v) const {
  v->T_Bold_Bcurrent = pose.T_O_U;
  v->covariance = pose.covariance;
  v->rmse_px = pose.rmse_px;
  v->inliers = static_cast<int>(pose.inliers.size());
  v->found = v->inliers;
  v->visible = 0;
  for (const std::vector<bool>& visible : problem.visible) {
    v->visible += static_cast<int>(std::count(visible.begin(), visible.end(), true));
  }
  CellSet old_cells;
  CellSet current_cells;
  for (const int i : pose.inliers) {
    const Match& match = problem.matches[static_cast<std::size_t>(i)];
    const Link& link = pair.links[match.link];
    const Eigen::Vector2f& point = link.points->point_pixels[static_cast<std::size_t>(match.point)];
    const Eigen::Vector2f& seen = link.image->keypoints[static_cast<std::size_t>(match.keypoint)];
    (link.is_reverse ? old_cells : current_cells).set(CellOf(point, *link.points_camera));
    (link.is_reverse ? current_cells : old_cells).set(CellOf(seen, *link.image_camera));
    v->pixel_matches.push_back({static_cast<int>(match.link / 2),
                                link.is_reverse ? point : seen,
                                link.is_reverse ? seen : point});
    if (match.link == 0) {
      v->point_matches.push_back({match.point, match.keypoint});
    }
  }
  v->cells = static_cast<int>(std::min(old_cells.count(), current_cells.count()));
}

// What several cameras of the rig show is one piece of evidence, and no more certain for that: the
// views come from one model.
void LoopVerifier::CountOnce(const Pair& pair,
                             const Problem& problem,
                             const RefinedPose& pose,
                             Verification* v) const {
  std::vector<bool> is_visible(pair.links.front().points->points_B.size(), false);
  std::vector<bool> is_found(is_visible.size(), false);
  std::vector<bool> is_seen(pair.links[1].image->keypoints.size(), false);
  for (std::size_t i = 0; i < pair.links.size(); ++i) {
    for (std::size_t k = 0; k < is_visible.size() && !pair.links[i].is_reverse; ++k) {
      is_visible[k] = is_visible[k] || problem.visible[i][k];
    }
  }
  for (const int i : pose.inliers) {
    const Match& match = problem.matches[static_cast<std::size_t>(i)];
    if (pair.links[match.link].is_reverse) {
      is_seen[static_cast<std::size_t>(match.keypoint)] = true;
    } else {
      is_found[static_cast<std::size_t>(match.point)] = true;
    }
  }
  const auto count = [](const std::vector<bool>& flags) {
    return static_cast<int>(std::count(flags.begin(), flags.end(), true));
  };
  v->visible = count(is_visible);
  v->found = count(is_found);
  v->inliers = v->found + count(is_seen);
  if (v->inliers > 0) {
    v->covariance *= static_cast<double>(pose.inliers.size()) / v->inliers;
  }
}

Verification LoopVerifier::Solve(const Pair& pair) const {
  Verification v;
  const RigGates gates = GatesOf(pair);
  const auto refine = [&](const Rigid3& start, const Problem& problem, bool use_gravity) {
    return RefineRelativePose(start,
                              problem.observations,
                              pair.gravity,
                              use_gravity,
                              camera_->FocalLength(),
                              options_.pose);
  };
  const std::optional<Rigid3> first = FirstPose(pair, &v);
  if (!first) {
    return v;
  }
  // Twice, the second time closer around the better pose: the wide window lets wrong neighbours in.
  Problem guided;
  Rigid3 T_old_current = *first;
  for (const double radius_px : {options_.guided_radius_px, options_.final_radius_px}) {
    guided = MatchAround(pair, T_old_current, radius_px);
    v.guided = static_cast<int>(guided.observations.size());
    if (v.guided < options_.min_ransac_inliers) {
      v.reason = RejectReason::kTooFewInliers;
      return v;
    }
    T_old_current = refine(T_old_current, guided, true).T_O_U;
  }
  v.gravity_disagreement =
      GravityDisagreement(refine(T_old_current, guided, false).T_O_U, pair.gravity);
  const RefinedPose pose = refine(T_old_current, guided, true);
  Summarise(pair, guided, pose, &v);
  if (pair.has_rig()) {
    CountOnce(pair, guided, pose, &v);
  }
  v.reason = Gate(v, gates);
  return v;
}

Verification LoopVerifier::Verify(const KeyframeFeatures& current,
                                  const Eigen::Quaterniond& q_W_Bcurrent,
                                  const KeyframeFeatures& old,
                                  const Eigen::Quaterniond& q_W_Bold) const {
  return VerifyRig(current, q_W_Bcurrent, old, q_W_Bold, {});
}

Verification LoopVerifier::VerifyRig(const KeyframeFeatures& current,
                                     const Eigen::Quaterniond& q_W_Bcurrent,
                                     const KeyframeFeatures& old,
                                     const Eigen::Quaterniond& q_W_Bold,
                                     const std::vector<RigCamera>& virtual_cameras) const {
  Pair pair;
  pair.gravity = {LevelRotation(q_W_Bold), LevelRotation(q_W_Bcurrent)};
  const Camera* camera = camera_.get();
  pair.links = {{&current, camera, &old, camera, false}, {&old, camera, &current, camera, true}};
  for (const RigCamera& view : virtual_cameras) {
    pair.links.push_back({&current, camera, &view.features, view.camera.get(), false});
    pair.links.push_back({&view.features, view.camera.get(), &current, camera, true});
  }
  return Solve(pair);
}

Agreement LoopVerifier::Agree(const RigCamera& virtual_camera,
                              const KeyframeFeatures& source) const {
  const KeyframeFeatures& view = virtual_camera.features;
  Pair pair;
  pair.links = {{&view, virtual_camera.camera.get(), &source, camera_.get(), false},
                {&source, camera_.get(), &view, virtual_camera.camera.get(), true}};
  const Problem problem = MatchAround(pair, Rigid3::Identity(), options_.final_radius_px);
  Agreement agreement;
  agreement.found = static_cast<int>(problem.matches.size());
  for (const std::vector<bool>& visible : problem.visible) {
    agreement.visible += static_cast<int>(std::count(visible.begin(), visible.end(), true));
  }
  return agreement;
}

RejectReason LoopVerifier::Gate(const Verification& v, const RigGates& gates) const {
  if (v.inliers < gates.min_inliers) {
    return RejectReason::kTooFewInliers;
  }
  if (v.found < gates.min_inlier_ratio * v.visible) {
    return RejectReason::kLowInlierRatio;
  }
  if (v.cells < gates.min_cells) {
    return RejectReason::kPoorSpread;
  }
  if (v.T_Bold_Bcurrent.t.norm() > options_.max_distance_m) {
    return RejectReason::kTooFar;
  }
  if (RotationAngle(v.T_Bold_Bcurrent.q) > options_.max_yaw_deg * kDegree) {
    return RejectReason::kTooMuchYaw;
  }
  if (v.gravity_disagreement > gates.max_gravity_deg * kDegree) {
    return RejectReason::kGravity;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(v.covariance.topLeftCorner<3, 3>(),
                                                             Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues().maxCoeff() < gates.max_sigma_m * gates.max_sigma_m)) {
    return RejectReason::kUncertain;
  }
  return RejectReason::kNone;
}

}  // namespace deja_view
