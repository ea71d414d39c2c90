// Which keyframes may show the same place, verifying them, and what follows from a loop.
#include "deja_view/base/angles.hpp"

#include <algorithm>
#include <utility>

#include "loop_closer_impl.hpp"
#include "own_points.hpp"
#include "step_timer.hpp"

namespace deja_view {
namespace {

constexpr double kLocalisedSeconds = 5.0;  // how long the corrected pose is the better guess
constexpr double kExpectedSigmas = 2.5;    // of a loop that says what the graph says

}  // namespace

NearbyPlace LoopCloserImpl::CameraOf(int keyframe) const {
  return {keyframe, keyframes_.T_M_C(keyframe)};
}

std::vector<NearbyPlace> LoopCloserImpl::CamerasAround(bool with_views) const {
  std::vector<NearbyPlace> cameras;
  for (const int place : keyframes_.places()) {
    if (!keyframes_.AreJoined(place, keyframes_.newest())) {
      continue;
    }
    const Rigid3 T_M_C = keyframes_.T_M_C(place);
    cameras.push_back({place, T_M_C});
    // A virtual camera is a place from which its keyframe knows the hall, too.
    if (with_views) {
      for (const StoredView& view : shelf_.Of(place)) {
        cameras.push_back({place, T_M_C * view.T_C_V});
      }
    }
  }
  return cameras;
}

bool LoopCloserImpl::IsLocalised() const {
  if (last_localised_ < 0) {
    return false;
  }
  const int newest = keyframes_.newest();
  return keyframes_.node(last_localised_).sequence == keyframes_.node(newest).sequence &&
         static_cast<double>(keyframes_[newest].stamp_ns - keyframes_[last_localised_].stamp_ns) <
             kLocalisedSeconds * 1e9;
}

std::vector<Candidate> LoopCloserImpl::FindCandidates(const NewKeyframe& current,
                                                      KeyframeReport* report) const {
  const StepTimer timer(&report->times.query);
  const int newest = keyframes_.newest();
  PlaceQuestion question;
  question.sequence = keyframes_.node(newest).sequence;
  question.stamp_ns = keyframes_[newest].stamp_ns;
  question.here = CameraOf(newest);
  question.around = CamerasAround(true);
  question.is_localised = IsLocalised();
  FoundPlaces found = places_.Find(question, current.words);
  report->best_place = found.best;
  return std::move(found.candidates);
}

// By where the newest keyframe should be, if that is known.
std::vector<std::vector<RigCamera>> LoopCloserImpl::RigsOf(int old,
                                                           const KeyframeFeatures& old_features,
                                                           const NewKeyframe& current) const {
  const int newest = keyframes_.newest();
  std::optional<NearCamera> near;
  if (keyframes_.AreJoined(old, newest)) {
    near = NearCamera{keyframes_.T_M_C(old).Inverse() * keyframes_.T_M_C(newest),
                      SceneDepth(old_features)};
  }
  return shelf_.RigsOf(old, old_features.T_B_C, near, current.words.bow);
}

// With views: by the first rig that is believed, or else what the best one said.
Verification LoopCloserImpl::VerifyPair(int old,
                                        const KeyframeFeatures& old_features,
                                        bool with_views,
                                        const NewKeyframe& current) const {
  const int newest = keyframes_.newest();
  const auto verify = [&](const std::vector<RigCamera>& rig) {
    return verifier_.VerifyRig(current.features,
                               keyframes_.node(newest).T_W_B.q,
                               old_features,
                               keyframes_.node(old).T_W_B.q,
                               rig,
                               keyframes_.AreJoined(old, newest)
                                   ? std::optional<Rigid3>(keyframes_.T_a_b(old, newest))
                                   : std::nullopt);
  };
  if (!with_views) {
    return verify({});
  }
  std::optional<Verification> best;
  for (const std::vector<RigCamera>& rig : RigsOf(old, old_features, current)) {
    Verification verification = verify(rig);
    if (!best || verification.reason == RejectReason::kNone) {
      best = std::move(verification);
    }
    if (best->reason == RejectReason::kNone) {
      break;
    }
  }
  return best ? *best : verify({});
}

LoopReport LoopCloserImpl::Verify(const Candidate& candidate,
                                  bool with_views,
                                  const NewKeyframe& current,
                                  Verification* verification) const {
  const int old = candidate.keyframe;
  const int newest = keyframes_.newest();
  *verification = VerifyPair(old, keyframes_.features(old), with_views, current);
  LoopReport report;
  report.is_virtual = with_views;
  report.current = newest;
  report.old = old;
  report.stamp_current_ns = keyframes_[newest].stamp_ns;
  report.stamp_old_ns = keyframes_[old].stamp_ns;
  report.T_Bold_Bcurrent = verification->T_Bold_Bcurrent;
  report.covariance = verification->covariance;
  report.scene_depth = verification->scene_depth;
  report.score = candidate.score;
  report.matches = verification->matches;
  report.inliers = verification->inliers;
  report.reason = verification->reason;
  return report;
}

Relocalisation LoopCloserImpl::MakeRelocalisation(const LoopReport& loop,
                                                  const Verification& verification,
                                                  const NewKeyframe& current) const {
  Relocalisation result;
  result.old = loop.old;
  result.T_M_Bold = keyframes_.node(loop.old).T_M_B();
  for (const PointMatch& match : verification.point_matches) {
    const std::int64_t id = current.features.point_ids[static_cast<std::size_t>(match.point)];
    const Eigen::Vector2f& pixel =
        keyframes_.features(loop.old).keypoints[static_cast<std::size_t>(match.keypoint)];
    const Eigen::Vector3d bearing = camera_->Unproject(pixel.cast<double>());
    if (id != kOwnPoint && bearing.z() > 1e-3) {  // it knows only its own tracks
      result.points.push_back({id, bearing.hnormalized()});
    }
  }
  return result;
}

std::vector<LoopMatches::Pair> LoopCloserImpl::PairsOf(const Verification& verification) {
  std::vector<LoopMatches::Pair> pairs;
  for (const PixelMatch& match : verification.pixel_matches) {
    pairs.push_back({match.camera, match.old_pixel, match.current_pixel});
  }
  return pairs;
}

bool LoopCloserImpl::TakeVerified(const LoopReport& loop,
                                  const Verification& verification,
                                  const NewKeyframe& current,
                                  KeyframeReport* report) {
  const int record = loops_.size();
  LoopBook::Entry entry = loops_.Enter(loop, &keyframes_.graph());
  if (entry.separates) {
    TakeBackJoin(std::move(entry.withdrawn), report);
  }
  const bool is_believed = entry.reason == RejectReason::kNone;
  if (!is_believed) {
    report->loops.push_back(loops_[record].report);
  }
  for (std::size_t i = 0; i < entry.believed.size(); ++i) {
    const LoopRecord& believed = loops_[entry.believed[i]];
    report->loops.push_back(believed.report);
    if (believed.edge >= 0) {
      const PoseGraph& graph = keyframes_.graph();
      solve_.NoteLoop(graph.loop(believed.edge), entry.joins && i == 0, graph);
    }
    last_localised_ = std::max(last_localised_, believed.report.current);
  }
  report->graph_changed = report->graph_changed || entry.joins;
  if (is_believed) {
    report->matches.push_back(
        {loop.stamp_current_ns, loop.stamp_old_ns, loop.is_virtual, PairsOf(verification)});
  }
  // The VIO takes pixels of the old real image: what virtual views alone show is of no use to it.
  if (is_believed && !loop.is_virtual && !report->relocalisation) {
    report->relocalisation = MakeRelocalisation(loop, verification, current);
    keyframes_.SetRelocalised(loop.current, loop.old);
  }
  return is_believed;
}

bool LoopCloserImpl::IsKnownWell(int record) const {
  const LoopRecord& loop = loops_[record];
  const PoseGraph& graph = keyframes_.graph();
  return options_.candidates.known_loops > 0 && loop.edge >= 0 &&
         loops_.CountOf(loop.report.old) > options_.candidates.known_loops &&
         graph.SquaredError(graph.loop(loop.edge)) < kExpectedSigmas * kExpectedSigmas;
}

// Where the flight knows its place in the map, a candidate that lies beyond what verification lets
// pass is not worth a rig.
bool LoopCloserImpl::IsWithinReach(int old, const NewKeyframe& current) const {
  const int newest = keyframes_.newest();
  if (!IsLocalised() || !keyframes_.AreJoined(old, newest)) {
    return true;
  }
  constexpr double kMargin = 0.2;  // of the scene's depth
  constexpr double kMarginDeg = 10.0;
  const Rigid3 T_old_newest = keyframes_.T_a_b(old, newest);
  const LoopVerifierOptions& gates = options_.verification;
  const double depth = std::max(SceneDepth(keyframes_.features(old)), SceneDepth(current.features));
  const bool is_near =
      depth == 0 || T_old_newest.t.norm() < (gates.max_distance_over_depth + kMargin) * depth;
  return is_near && RotationAngle(T_old_newest.q) < kDegree * (gates.max_yaw_deg + kMarginDeg);
}

// The real images of all candidates first: a rig costs several times as much, and is of use only
// where they don't do. Where a place is known well, one loop is enough: what many loops have tied
// needs no more of them, and a flight of hours over it would verify the same again and again. But
// own places don't keep a flight from finding a map that it has not joined yet.
void LoopCloserImpl::FindLoops(const std::vector<Candidate>& candidates,
                               const NewKeyframe& current,
                               KeyframeReport* report) {
  const StepTimer timer(&report->times.verification);
  int wanted = options_.candidates.max_loops;
  int rigs = 0;
  const auto is_wanted = [&](const Candidate& candidate) {
    return wanted > 0 || !keyframes_.AreJoined(candidate.keyframe, keyframes_.newest());
  };
  const auto take = [&](const LoopReport& loop, const Verification& verification) {
    const int record = loops_.size();
    if (TakeVerified(loop, verification, current, report)) {
      wanted = IsKnownWell(record) ? 0 : wanted - 1;
    }
  };
  std::vector<std::pair<Candidate, LoopReport>> failed;
  for (const Candidate& candidate : candidates) {
    if (!is_wanted(candidate)) {
      continue;
    }
    Verification verification;
    const LoopReport loop = Verify(candidate, false, current, &verification);
    if (loop.reason == RejectReason::kNone) {
      take(loop, verification);
    } else {
      failed.emplace_back(candidate, loop);
    }
  }
  for (auto& [candidate, loop] : failed) {
    const bool is_worth_it =
        !shelf_.Of(candidate.keyframe).empty() && IsWithinReach(candidate.keyframe, current);
    Verification verification;
    if (is_worth_it && is_wanted(candidate) && rigs < options_.views.max_tried) {
      ++rigs;
      loop = Verify(candidate, true, current, &verification);
    }
    if (loop.reason == RejectReason::kNone) {
      take(loop, verification);
    } else {
      report->loops.push_back(loop);
    }
  }
}

}  // namespace deja_view
