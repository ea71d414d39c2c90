// What a pose rests on, and whether that is enough.
#include "deja_view/base/angles.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/features/keypoint_grid.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "chance_of_support.hpp"
#include "loop_verifier_parts.hpp"
#include <Eigen/Eigenvalues>

namespace deja_view {
namespace {

double Median(std::vector<double>* values) {
  if (values->empty()) {
    return 0.0;
  }
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace

double SceneDepth(const KeyframeFeatures& keyframe) {
  std::vector<double> depths;
  for (const Eigen::Vector3f& point : keyframe.points_B) {
    depths.push_back((point.cast<double>() - keyframe.T_B_C.t).norm());
  }
  return Median(&depths);
}

double OverlapShare(const KeyframeFeatures& from,
                    const KeyframeFeatures& to,
                    const Rigid3& T_to_from,
                    const Camera& camera) {
  const Rigid3 T_C_from = to.T_B_C.Inverse() * T_to_from;
  const auto shows = [&](const Eigen::Vector3f& point) {
    const auto pixel = camera.Project(T_C_from * point.cast<double>());
    return pixel && camera.IsInImage(*pixel);
  };
  const auto shown = std::count_if(from.points_B.begin(), from.points_B.end(), shows);
  return from.points_B.empty()
             ? 0.0
             : static_cast<double>(shown) / static_cast<double>(from.points_B.size());
}

std::vector<std::string> LoopVerifierOptions::Validate() const {
  Requirements r;
  r.Range("max_distance", max_distance, 1, 256);
  r.That(max_ratio > 0 && max_ratio <= 1, "max_ratio", max_ratio, "more than 0, at most 1");
  r.That(min_matches >= 3, "min_matches", min_matches, "at least 3");
  r.That(min_ransac_inliers >= 3, "min_ransac_inliers", min_ransac_inliers, "at least 3");
  r.That(predicted_radius_px >= 0, "predicted_radius_px", predicted_radius_px, "at least 0");
  r.That(guided_radius_px > 0, "guided_radius_px", guided_radius_px, "more than 0");
  r.That(final_radius_px > 0, "final_radius_px", final_radius_px, "more than 0");
  r.Range("guided_max_distance", guided_max_distance, 1, 256);
  r.That(max_log10_false_alarms < 0, "max_log10_false_alarms", max_log10_false_alarms, "below 0");
  r.Range("min_inlier_ratio", min_inlier_ratio, 0, 1);
  r.That(max_distance_over_depth > 0,
         "max_distance_over_depth",
         max_distance_over_depth,
         "more than 0");
  r.That(max_yaw_deg > 0, "max_yaw_deg", max_yaw_deg, "more than 0");
  r.That(max_gravity_deg > 0, "max_gravity_deg", max_gravity_deg, "more than 0");
  r.That(max_sigma_over_depth > 0, "max_sigma_over_depth", max_sigma_over_depth, "more than 0");
  r.That(max_sigma_m > 0, "max_sigma_m", max_sigma_m, "more than 0");
  r.Group("rig", rig.Validate());
  r.Group("pose", pose.Validate());
  return r.errors();
}

std::vector<std::string> RigGates::Validate() const {
  Requirements r;
  r.Range("min_ransac_ratio", min_ransac_ratio, 0, 1);
  r.That(max_log10_false_alarms < 0, "max_log10_false_alarms", max_log10_false_alarms, "below 0");
  r.Range("min_inlier_ratio", min_inlier_ratio, 0, 1);
  r.That(max_gravity_deg > 0, "max_gravity_deg", max_gravity_deg, "more than 0");
  r.That(max_sigma_over_depth > 0, "max_sigma_over_depth", max_sigma_over_depth, "more than 0");
  return r.errors();
}

RigGates LoopVerifier::GatesOf(bool has_rig) const {
  return has_rig ? options_.rig
                 : RigGates{0.0,
                            options_.max_log10_false_alarms,
                            options_.min_inlier_ratio,
                            options_.max_gravity_deg,
                            options_.max_sigma_over_depth};
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
  std::vector<double> depths;
  for (const int i : pose.inliers) {
    const Match& match = problem.matches[static_cast<std::size_t>(i)];
    const Link& link = pair.links[match.link];
    const Eigen::Vector2f& point = link.points->point_pixels[static_cast<std::size_t>(match.point)];
    const Eigen::Vector2f& seen = link.image->keypoints[static_cast<std::size_t>(match.keypoint)];
    v->pixel_matches.push_back(
        {link.camera, link.is_reverse ? point : seen, link.is_reverse ? seen : point});
    if (match.link == 0) {
      v->point_matches.push_back({match.point, match.keypoint});
    }
    depths.push_back(
        (problem.observations[static_cast<std::size_t>(i)].point - link.points->T_B_C.t).norm());
  }
  v->scene_depth = Median(&depths);
  if (!pair.has_rig()) {
    v->covariance *= Crowding(v->pixel_matches);
  }
}

// What shifts one match, a lens or a depth that is a little off, shifts its neighbours as well.
double LoopVerifier::Crowding(const std::vector<PixelMatch>& matches) const {
  std::vector<bool> is_taken(kImageCells, false);
  for (const PixelMatch& match : matches) {
    is_taken[CellOf(match.current_pixel, camera_->width(), camera_->height())] = true;
  }
  const auto taken = std::count(is_taken.begin(), is_taken.end(), true);
  return taken > 0 ? static_cast<double>(matches.size()) / static_cast<double>(taken) : 1.0;
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

double LoopVerifier::Log10FalseAlarms(const Pair& pair,
                                      const Problem& problem,
                                      const RefinedPose& pose,
                                      double log10_tests) const {
  constexpr float kAround = 3.0F;  // windows over which the density of keypoints is taken
  constexpr int kSpent = 2;        // matches that make a pose
  const auto radius = static_cast<float>(options_.final_radius_px);
  // Several images of a rig, all made from one model, show the same: of a cell, they count once.
  std::vector<std::size_t> first_group;
  std::size_t groups = 0;
  for (const Link& link : pair.links) {
    first_group.push_back(groups);
    groups += link.points->points_B.size();
  }
  const auto group_of = [&](std::size_t link, std::size_t point, const Eigen::Vector2f& pixel) {
    return pair.has_rig() ? CellOf(pixel, camera_->width(), camera_->height())
                          : first_group[link] + point;
  };
  ChanceOfSupport chance(pair.has_rig() ? kImageCells : groups);
  for (std::size_t i = 0; i < pair.links.size(); ++i) {
    const Link& link = pair.links[i];
    const Rigid3 T_image_points = link.is_reverse ? pose.T_O_U.Inverse() : pose.T_O_U;
    const Rigid3 T_C_points = link.image->T_B_C.Inverse() * T_image_points;
    const KeypointGrid grid(link.image->keypoints,
                            link.image_camera->width(),
                            link.image_camera->height(),
                            internal::kGridCellPx);
    for (std::size_t k = 0; k < link.points->points_B.size(); ++k) {
      const auto pixel =
          link.image_camera->Project(T_C_points * link.points->points_B[k].cast<double>());
      if (!problem.visible[i][k] || !pixel) {
        continue;
      }
      int near = 1;
      grid.ForEachNear(pixel->cast<float>(), kAround * radius, [&](int) { ++near; });
      const double probability = ChanceOfMatch(link.points->point_descriptors[k],
                                               link.image->descriptors,
                                               options_.guided_max_distance,
                                               static_cast<double>(near) / (kAround * kAround));
      chance.AddVisible(
          group_of(
              i, k, link.is_reverse ? pixel->cast<float>().eval() : link.points->point_pixels[k]),
          probability);
    }
  }
  for (const int i : pose.inliers) {
    const Match& match = problem.matches[static_cast<std::size_t>(i)];
    const Link& link = pair.links[match.link];
    const auto point = static_cast<std::size_t>(match.point);
    chance.AddFound(group_of(match.link,
                             point,
                             link.is_reverse
                                 ? link.image->keypoints[static_cast<std::size_t>(match.keypoint)]
                                 : link.points->point_pixels[point]));
  }
  return log10_tests + chance.Log10Probability(kSpent);
}

std::vector<GateReading> LoopVerifier::Readings(const Verification& v, bool with_rig) const {
  const RigGates gates = GatesOf(with_rig);
  const std::string group = with_rig ? "rig." : "";
  const auto over_depth = [&](double metres) {
    return v.scene_depth > 0 ? metres / v.scene_depth : std::numeric_limits<double>::infinity();
  };
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(v.covariance.topLeftCorner<3, 3>(),
                                                             Eigen::EigenvaluesOnly);
  const double variance = eigen.eigenvalues().maxCoeff();
  const double sigma =
      variance >= 0 ? std::sqrt(variance) : std::numeric_limits<double>::infinity();
  return {
      {RejectReason::kByChance,
       group + "max_log10_false_alarms",
       v.log10_false_alarms,
       gates.max_log10_false_alarms},
      {RejectReason::kLowInlierRatio,
       group + "min_inlier_ratio",
       v.visible > 0 ? static_cast<double>(v.found) / v.visible : 1.0,
       gates.min_inlier_ratio,
       true},
      {RejectReason::kTooFar,
       "max_distance_over_depth",
       over_depth(v.T_Bold_Bcurrent.t.norm()),
       options_.max_distance_over_depth},
      {RejectReason::kTooMuchYaw,
       "max_yaw_deg",
       RotationAngle(v.T_Bold_Bcurrent.q) / kDegree,
       options_.max_yaw_deg},
      {RejectReason::kGravity,
       group + "max_gravity_deg",
       v.gravity_disagreement / kDegree,
       gates.max_gravity_deg},
      {RejectReason::kUncertain,
       group + "max_sigma_over_depth",
       over_depth(sigma),
       gates.max_sigma_over_depth},
      {RejectReason::kUncertain, "max_sigma_m", sigma, options_.max_sigma_m},
  };
}

RejectReason LoopVerifier::Gate(const Verification& v, bool has_rig) const {
  for (const GateReading& reading : Readings(v, has_rig)) {
    if (!reading.passes()) {
      return reading.reason;
    }
  }
  return RejectReason::kNone;
}

}  // namespace deja_view
