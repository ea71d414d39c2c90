#include "deja_view/verification/loop_verifier.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/hamming_matcher.hpp"
#include "deja_view/features/keypoint_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loop_verifier_parts.hpp"

namespace deja_view {
namespace {

Eigen::Vector3d ToDouble(const Eigen::Vector3f& v) {
  return v.cast<double>();
}

}  // namespace

std::size_t KeyframeFeatures::MemoryBytes() const {
  const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v.front()); };
  return bytes(keypoints) + bytes(descriptors) + bytes(points_B) + bytes(point_pixels) +
         bytes(point_depth_sigmas) + bytes(point_ids) + bytes(point_descriptors);
}

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
  const KeypointGrid grid(image.keypoints, camera.width(), camera.height(), internal::kGridCellPx);
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
      v->ransac_inliers < GatesOf(pair.has_rig()).min_ransac_ratio * v->matches) {
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

void LoopVerifier::SolveFrom(const Rigid3& first,
                             const std::vector<double>& radii_px,
                             double log10_tests,
                             const Pair& pair,
                             Verification* v) const {
  const auto refine = [&](const Rigid3& start, const Problem& problem, bool use_gravity) {
    return RefineRelativePose(start,
                              problem.observations,
                              pair.gravity,
                              use_gravity,
                              camera_->FocalLength(),
                              options_.pose);
  };
  // Ever closer around the better pose: a wide window lets wrong neighbours in.
  Problem guided;
  Rigid3 T_old_current = first;
  for (const double radius_px : radii_px) {
    guided = MatchAround(pair, T_old_current, radius_px);
    v->guided = static_cast<int>(guided.observations.size());
    if (v->guided < options_.min_ransac_inliers) {
      v->reason = RejectReason::kTooFewInliers;
      return;
    }
    T_old_current = refine(T_old_current, guided, true).T_O_U;
  }
  v->gravity_disagreement =
      GravityDisagreement(refine(T_old_current, guided, false).T_O_U, pair.gravity);
  const RefinedPose pose = refine(T_old_current, guided, true);
  Summarise(pair, guided, pose, v);
  if (pair.has_rig()) {
    CountOnce(pair, guided, pose, v);
  }
  v->log10_false_alarms = Log10FalseAlarms(pair, guided, pose, log10_tests);
  v->reason = Gate(*v, pair.has_rig());
}

Verification LoopVerifier::Solve(const Pair& pair, const std::optional<Rigid3>& predicted) const {
  Verification v;
  const std::optional<Rigid3> first = FirstPose(pair, &v);
  if (first) {
    const double pairs_of_matches = 0.5 * v.matches * (v.matches - 1);
    constexpr double kPosesPerPair = 2;
    SolveFrom(*first,
              {options_.guided_radius_px, options_.final_radius_px},
              std::log10(kPosesPerPair * pairs_of_matches),
              pair,
              &v);
  }
  if (v.reason == RejectReason::kNone || !predicted || options_.predicted_radius_px <= 0) {
    return v;
  }
  Verification again;
  again.matches = v.matches;
  again.ransac_inliers = v.ransac_inliers;
  // Poses that are told apart by the final window, in four degrees of freedom.
  const double per_axis = std::max(1.0, options_.predicted_radius_px / options_.final_radius_px);
  SolveFrom(*predicted,
            {options_.predicted_radius_px, options_.guided_radius_px, options_.final_radius_px},
            4.0 * std::log10(per_axis),
            pair,
            &again);
  return again.reason == RejectReason::kNone ? again : v;
}

Verification LoopVerifier::Verify(const KeyframeFeatures& current,
                                  const Eigen::Quaterniond& q_W_Bcurrent,
                                  const KeyframeFeatures& old,
                                  const Eigen::Quaterniond& q_W_Bold,
                                  const std::optional<Rigid3>& T_Bold_Bcurrent_predicted) const {
  return VerifyRig(current, q_W_Bcurrent, old, q_W_Bold, {}, T_Bold_Bcurrent_predicted);
}

Verification LoopVerifier::VerifyRig(const KeyframeFeatures& current,
                                     const Eigen::Quaterniond& q_W_Bcurrent,
                                     const KeyframeFeatures& old,
                                     const Eigen::Quaterniond& q_W_Bold,
                                     const std::vector<RigCamera>& virtual_cameras,
                                     const std::optional<Rigid3>& T_Bold_Bcurrent_predicted) const {
  Pair pair;
  pair.gravity = {LevelRotation(q_W_Bold), LevelRotation(q_W_Bcurrent)};
  const Camera* camera = camera_.get();
  pair.links = {{&current, camera, &old, camera, false}, {&old, camera, &current, camera, true}};
  for (const RigCamera& view : virtual_cameras) {
    pair.links.push_back({&current, camera, &view.features, view.camera.get(), false, view.number});
    pair.links.push_back({&view.features, view.camera.get(), &current, camera, true, view.number});
  }
  return Solve(pair, T_Bold_Bcurrent_predicted);
}

std::vector<PixelMatch> LoopVerifier::FirstMatches(const KeyframeFeatures& current,
                                                   const KeyframeFeatures& old) const {
  std::vector<PixelMatch> pixels;
  for (const bool is_reverse : {false, true}) {
    const Link link{is_reverse ? &old : &current,
                    camera_.get(),
                    is_reverse ? &current : &old,
                    camera_.get(),
                    is_reverse};
    for (const Match& match : MatchAll(link)) {
      const Eigen::Vector2f& point =
          link.points->point_pixels[static_cast<std::size_t>(match.point)];
      const Eigen::Vector2f& seen = link.image->keypoints[static_cast<std::size_t>(match.keypoint)];
      pixels.push_back(
          {PixelMatch::kRealCamera, is_reverse ? point : seen, is_reverse ? seen : point});
    }
  }
  return pixels;
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

}  // namespace deja_view
