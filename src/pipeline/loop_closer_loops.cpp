// Verifying candidates, and what follows from a loop.
#include <algorithm>
#include <utility>

#include "loop_closer_impl.hpp"
#include "stopwatch.hpp"

namespace deja_view {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

}  // namespace

LoopReport LoopCloser::Impl::VerifyCandidate(const Candidate& candidate,
                                             bool with_views,
                                             Verification* verification) const {
  const auto old = static_cast<std::size_t>(candidate.keyframe);
  const std::size_t current = keyframes.size() - 1;
  *verification = verifier.VerifyRig(keyframes[current].features,
                                     graph.nodes()[current].T_W_B.q,
                                     keyframes[old].features,
                                     graph.nodes()[old].T_W_B.q,
                                     with_views ? RigOf(old) : std::vector<RigCamera>());
  LoopReport report;
  report.is_virtual = with_views;
  report.current = static_cast<int>(current);
  report.old = candidate.keyframe;
  report.stamp_current_ns = keyframes[current].stamp_ns;
  report.stamp_old_ns = keyframes[old].stamp_ns;
  report.T_Bold_Bcurrent = verification->T_Bold_Bcurrent;
  report.covariance = verification->covariance;
  report.score = candidate.score;
  report.matches = verification->matches;
  report.inliers = verification->inliers;
  report.reason = verification->reason;
  return report;
}

Relocalisation LoopCloser::Impl::MakeRelocalisation(const LoopReport& loop,
                                                    const Verification& verification) const {
  Relocalisation result;
  result.old = loop.old;
  const auto old = static_cast<std::size_t>(loop.old);
  result.T_M_Bold = graph.nodes()[old].T_M_B();
  const KeyframeFeatures& current_features = keyframes.back().features;
  for (const PointMatch& match : verification.point_matches) {
    const Eigen::Vector2f& pixel =
        keyframes[old].features.keypoints[static_cast<std::size_t>(match.keypoint)];
    const Eigen::Vector3d bearing = camera->Unproject(pixel.cast<double>());
    if (bearing.z() > 1e-3) {
      result.points.push_back({current_features.point_ids[static_cast<std::size_t>(match.point)],
                               bearing.hnormalized()});
    }
  }
  return result;
}

LoopMatches LoopCloser::Impl::MakeMatches(const LoopReport& loop,
                                          const Verification& verification) const {
  LoopMatches matches{loop.stamp_current_ns, loop.stamp_old_ns, loop.is_virtual, {}};
  const std::vector<StoredView>& views = keyframes[static_cast<std::size_t>(loop.old)].views;
  for (const PixelMatch& match : verification.pixel_matches) {
    const int view =
        match.camera == 0 ? -1 : views[static_cast<std::size_t>(match.camera - 1)].index;
    matches.pairs.push_back({view, match.old_pixel, match.current_pixel});
  }
  return matches;
}

bool LoopCloser::Impl::TakeVerified(LoopReport loop,
                                    const Verification& verification,
                                    KeyframeReport* report) {
  PoseGraphLoop edge;
  edge.from = loop.old;
  edge.to = loop.current;
  edge.T_from_to = loop.T_Bold_Bcurrent;
  edge.covariance = loop.covariance;
  reports.push_back(loop);
  const LoopConsistency::Decision decision =
      consistency.Add(edge, static_cast<int>(reports.size()) - 1, graph);
  const bool is_believed = decision.state == LoopConsistency::State::kAccepted;
  if (!is_believed) {
    loop.reason = decision.state == LoopConsistency::State::kImplausible
                      ? RejectReason::kImplausible
                      : RejectReason::kInconsistent;
    report->loops.push_back(loop);
  }
  report->reason = loop.reason;
  Believe(decision.believed, report);
  if (is_believed) {
    report->matches.push_back(MakeMatches(loop, verification));
  }
  // The VIO takes pixels of the old real image: what virtual views alone show is of no use to it.
  if (is_believed && !loop.is_virtual && !report->relocalisation) {
    report->relocalisation = MakeRelocalisation(loop, verification);
    keyframes.back().relocalised_old = loop.old;
  }
  return is_believed;
}

// Where the flight knows its place in the map, a candidate that lies beyond what verification lets
// pass is not worth a rig.
bool LoopCloser::Impl::IsWithinReach(int old) const {
  if (!IsLocalised() || !graph.AreJoined(keyframes[static_cast<std::size_t>(old)].sequence,
                                         keyframes.back().sequence)) {
    return true;
  }
  constexpr double kMarginM = 1.0;
  constexpr double kMarginDeg = 10.0;
  const Rigid3 T_old_current =
      graph.nodes()[static_cast<std::size_t>(old)].T_M_B().Inverse() * graph.nodes().back().T_M_B();
  return T_old_current.t.norm() < options.verification.max_distance_m + kMarginM &&
         RotationAngle(T_old_current.q) < kDegree * (options.verification.max_yaw_deg + kMarginDeg);
}

// The real images of all candidates first: a rig costs several times as much, and is of use only
// where they don't do.
void LoopCloser::Impl::FindLoops(KeyframeReport* report) {
  const std::vector<Candidate> candidates = FindCandidates(report);
  Stopwatch watch;
  int found = 0;
  int rigs = 0;
  std::vector<std::pair<Candidate, LoopReport>> failed;
  for (const Candidate& candidate : candidates) {
    if (found >= options.candidates.max_loops) {
      break;
    }
    Verification verification;
    const LoopReport loop = VerifyCandidate(candidate, false, &verification);
    if (loop.reason == RejectReason::kNone) {
      found += TakeVerified(loop, verification, report) ? 1 : 0;
    } else {
      failed.emplace_back(candidate, loop);
    }
  }
  for (auto& [candidate, loop] : failed) {
    const bool is_worth_it =
        !keyframes[static_cast<std::size_t>(candidate.keyframe)].views.empty() &&
        IsWithinReach(candidate.keyframe);
    Verification verification;
    if (is_worth_it && found < options.candidates.max_loops && rigs < options.views.max_tried) {
      ++rigs;
      loop = VerifyCandidate(candidate, true, &verification);
    }
    if (loop.reason == RejectReason::kNone) {
      found += TakeVerified(loop, verification, report) ? 1 : 0;
    } else {
      report->reason = loop.reason;
      report->loops.push_back(loop);
    }
  }
  if (found > 0) {
    report->reason = RejectReason::kNone;
  }
  report->times.verification = watch.LapMs();
}

void LoopCloser::Impl::Believe(const std::vector<LoopConsistency::Entry>& entries,
                               KeyframeReport* report) {
  for (const LoopConsistency::Entry& entry : entries) {
    const bool was_joined =
        graph.AreJoined(keyframes[static_cast<std::size_t>(entry.loop.from)].sequence,
                        keyframes[static_cast<std::size_t>(entry.loop.to)].sequence);
    graph.AddLoop(entry.loop);
    LoopReport loop = reports[static_cast<std::size_t>(entry.tag)];
    loop.reason = RejectReason::kNone;
    accepted.push_back(loop);
    report->loops.push_back(loop);
    ++loops_since_solve_;
    is_surprised_ =
        is_surprised_ || !was_joined ||
        graph.SquaredError(entry.loop) > options.solve.surprise * options.solve.surprise;
    report->graph_changed = report->graph_changed || !was_joined;
    last_localised_ = std::max(last_localised_, entry.loop.to);
  }
}
}  // namespace deja_view
