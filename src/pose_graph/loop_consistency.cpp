#include "deja_view/pose_graph/loop_consistency.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/pose_graph/four_dof_error.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace deja_view {
namespace {

/// What the trajectory would have to move for a loop.
struct Claim {
  double distance = 0;  ///< [m]
  double yaw = 0;       ///< [rad], not negative
};

Claim ClaimOf(const PoseGraphLoop& loop, const PoseGraph& graph) {
  const PoseGraphNode from = graph.node(loop.from);
  const PoseGraphNode to = graph.node(loop.to);
  const Eigen::Vector3d predicted = (from.T_M_B().Inverse() * to.T_M_B()).t;
  const double yaw =
      WrapAngle(to.psi - from.psi - DeltaPsi(from.T_W_B.q, loop.T_from_to.q, to.T_W_B.q));
  return {(predicted - loop.T_from_to.t).norm(), std::abs(yaw)};
}

/// In standard deviations per degree of freedom.
double NormalisedInnovation(const PoseGraphLoop& loop, const PoseGraph& graph) {
  constexpr double kDegreesOfFreedom = 4;
  return std::sqrt(graph.SquaredError(loop) / kDegreesOfFreedom);
}

}  // namespace

std::vector<std::string> LoopConsistencyOptions::Validate() const {
  Requirements r;
  const auto at_least = [&](const char* key, double value, double least) {
    r.That(value >= least, key, value, least > 0 ? "at least 1" : "at least 0");
  };
  const auto positive = [&](const char* key, double value) {
    r.That(value > 0, key, value, "more than 0");
  };
  at_least("min_support", min_support, 0);
  at_least("min_support_join", min_support_join, 0);
  at_least("max_support_ratio", max_support_ratio, 0);
  at_least("min_span_over_depth", min_span_over_depth, 0);
  at_least("same_place_over_depth", same_place_over_depth, 0);
  at_least("max_rival_ratio", max_rival_ratio, 0);
  at_least("rival_over_depth", rival_over_depth, 0);
  at_least("rival_yaw_deg", rival_yaw_deg, 0);
  at_least("span_window", span_window, 1);
  at_least("window", window, 1);
  positive("max_path_over_depth", max_path_over_depth);
  positive("max_sigmas", max_sigmas);
  positive("plausible_soon_over_depth", plausible_soon_over_depth);
  positive("plausible_over_depth", plausible_over_depth);
  positive("surprising_over_depth", surprising_over_depth);
  positive("max_innovation_ratio", max_innovation_ratio);
  at_least("plausible_m_per_m", plausible_m_per_m, 0);
  positive("plausible_yaw_deg", plausible_yaw_deg);
  at_least("plausible_yaw_deg_per_m", plausible_yaw_deg_per_m, 0);
  return r.errors();
}

LoopConsistency::Comparison LoopConsistency::Compare(const PoseGraphLoop& a,
                                                     const PoseGraphLoop& b,
                                                     const PoseGraph& graph) const {
  Comparison result;
  const PoseGraphNode a_from = graph.node(a.from);
  const PoseGraphNode b_from = graph.node(b.from);
  const PoseGraphNode a_to = graph.node(a.to);
  const PoseGraphNode b_to = graph.node(b.to);
  // A loaded map's poses are solved: neither drift nor the way flown lies between them.
  const bool is_map =
      a_from.is_fixed && b_from.is_fixed && graph.AreJoinedInMap(a_from.sequence, b_from.sequence);
  if ((a_from.sequence != b_from.sequence && !is_map) || a_to.sequence != b_to.sequence) {
    return result;
  }
  const Rigid3 T_from =
      is_map ? a_from.T_M_B().Inverse() * b_from.T_M_B() : a_from.T_W_B.Inverse() * b_from.T_W_B;
  const double from_path = is_map ? T_from.t.norm() : graph.PathLength(a.from, b.from);
  const double to_path = graph.PathLength(a.to, b.to);
  const double max_path = options_.max_path_over_depth * std::min(a.scene_depth, b.scene_depth);
  if (from_path > max_path || to_path > max_path) {
    return result;
  }
  result.is_comparable = true;

  const Rigid3 around = T_from * b.T_from_to * b_to.T_W_B.Inverse() * a_to.T_W_B;
  const Eigen::Vector3d dt = around.t - a.T_from_to.t;
  const double dpsi = WrapAngle(DeltaPsi(a_from.T_W_B.q, around.q, a_to.T_W_B.q) -
                                DeltaPsi(a_from.T_W_B.q, a.T_from_to.q, a_to.T_W_B.q));
  const PoseGraphOptions& noise = graph.options();
  const double path = from_path + to_path;
  const double yaw_variance =
      std::pow(kDegree, 2) * (std::pow(noise.odometry_yaw_sigma_per_sqrt_m_deg, 2) * path +
                              2.0 * std::pow(noise.loop_yaw_sigma_floor_deg, 2)) +
      (a.covariance.bottomRightCorner<3, 3>() + b.covariance.bottomRightCorner<3, 3>()).trace() / 3;
  const double lever = std::max(from_path, to_path);
  const double variance =
      std::pow(noise.odometry_sigma_per_sqrt_m, 2) * path +
      (graph.LoopCommonCovariance(a.T_from_to.t) + graph.LoopCommonCovariance(b.T_from_to.t))
              .trace() /
          3 +
      yaw_variance * lever * lever / 4.0 +
      (a.covariance.topLeftCorner<3, 3>() + b.covariance.topLeftCorner<3, 3>()).trace() / 3;
  const double limit = options_.max_sigmas * options_.max_sigmas;
  result.agrees = dt.squaredNorm() < 3.0 * limit * variance && dpsi * dpsi < limit * yaw_variance;
  const double depth = std::min(a.scene_depth, b.scene_depth);
  result.rivals = !result.agrees && (dt.norm() > options_.rival_over_depth * depth ||
                                     std::abs(dpsi) > kDegree * options_.rival_yaw_deg);
  return result;
}

bool LoopConsistency::IsFollowed(const PoseGraphLoop& loop, const PoseGraph& graph) const {
  const Claim claim = ClaimOf(loop, graph);
  return claim.distance < options_.surprising_over_depth * loop.scene_depth &&
         claim.yaw < kDegree * options_.plausible_yaw_deg;
}

std::vector<int> LoopConsistency::HeldNodes(const PoseGraph& graph) const {
  std::vector<int> held;
  for (const auto& [sequence, node] : forgotten_) {
    held.push_back(node);
  }
  for (const Entry& entry : entries_) {
    if (entry.state == State::kAccepted && IsFollowed(entry.loop, graph)) {
      held.push_back(entry.loop.to);
    }
  }
  return held;
}

double LoopConsistency::PathToHeld(int node,
                                   const std::vector<int>& held,
                                   const PoseGraph& graph) const {
  const int sequence = graph.node(node).sequence;
  std::optional<double> path;
  for (const int other : held) {
    if (graph.node(other).sequence == sequence) {
      const double way = graph.PathLength(other, node);
      path = std::min(path.value_or(way), way);
    }
  }
  return path.value_or(graph.PathFromStart(node));
}

void LoopConsistency::ForgetOldest(const PoseGraph& graph) {
  while (static_cast<int>(entries_.size()) > memory()) {
    const Entry& oldest = entries_.front();
    if (oldest.state == State::kAccepted && IsFollowed(oldest.loop, graph)) {
      forgotten_[graph.node(oldest.loop.to).sequence] = oldest.loop.to;
    }
    entries_.pop_front();
  }
}

void LoopConsistency::Withdraw(int tag, int from, int to, const PoseGraph& graph) {
  entries_.erase(
      std::remove_if(
          entries_.begin(), entries_.end(), [tag](const Entry& entry) { return entry.tag == tag; }),
      entries_.end());
  const auto joining = joining_.find({graph.node(from).sequence, graph.node(to).sequence});
  if (joining != joining_.end() && --joining->second[from] <= 0) {
    joining->second.erase(from);
  }
}

bool LoopConsistency::IsPlausible(const PoseGraphLoop& loop,
                                  double path,
                                  const PoseGraph& graph) const {
  const Claim claim = ClaimOf(loop, graph);
  const bool is_surprising =
      claim.distance > options_.surprising_over_depth * loop.scene_depth &&
      NormalisedInnovation(loop, graph) > options_.max_innovation_ratio * UsualInnovation();
  const double soon =
      is_surprising ? std::min(options_.surprising_over_depth, options_.plausible_soon_over_depth)
                    : options_.plausible_soon_over_depth;
  const double over_depth =
      soon + std::min(1.0, path / loop.scene_depth) * (options_.plausible_over_depth - soon);
  return claim.distance < over_depth * loop.scene_depth + options_.plausible_m_per_m * path &&
         claim.yaw <
             kDegree * (options_.plausible_yaw_deg + options_.plausible_yaw_deg_per_m * path);
}

double LoopConsistency::UsualInnovation() const {
  // Before there are loops to learn from: more than the covariances say, which points and odometry
  // of a real camera don't keep.
  constexpr double kExpected = 1.5;
  constexpr double kWorthLoops = 10;
  double sum = kWorthLoops * kExpected * kExpected;
  double count = kWorthLoops;
  for (const Entry& entry : entries_) {
    if (entry.innovation >= 0) {
      sum += entry.innovation * entry.innovation;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

LoopConsistency::State LoopConsistency::StateOf(const Entry& entry,
                                                double path,
                                                const PoseGraph& graph) const {
  int support = 0;
  int against = 0;
  const std::size_t begin =
      entries_.size() -
      std::min<std::size_t>(entries_.size(), static_cast<std::size_t>(options_.window));
  for (std::size_t i = begin; i < entries_.size(); ++i) {
    const Entry& other = entries_[i];
    if (&other == &entry || other.loop.to == entry.loop.to) {
      continue;
    }
    const Comparison c = Compare(entry.loop, other.loop, graph);
    support += c.is_comparable && c.agrees ? 1 : 0;
    against += c.is_comparable && !c.agrees && other.state == State::kAccepted ? 1 : 0;
  }
  if (against > options_.max_support_ratio * support) {
    return State::kPending;
  }
  if (!IsPlausible(entry.loop, path, graph)) {
    return State::kImplausible;
  }
  return support >= options_.min_support ? State::kAccepted : State::kPending;
}

void LoopConsistency::Believe(Entry* entry, const PoseGraph& graph) {
  entry->state = State::kAccepted;
  const int from = graph.node(entry->loop.from).sequence;
  const int to = graph.node(entry->loop.to).sequence;
  if (from != to) {
    ++joining_[{from, to}][entry->loop.from];
  }
}

// Within one world: the newest loop, and those waiting that it can have helped.
std::vector<LoopConsistency::Entry> LoopConsistency::Judge(const PoseGraphLoop& loop,
                                                           const PoseGraph& graph) {
  std::vector<Entry> believed;
  const std::size_t begin =
      entries_.size() -
      std::min<std::size_t>(entries_.size(), static_cast<std::size_t>(options_.window));
  // Oldest first. Judged against the entries as they stand: one that is believed now speaks against
  // later ones at the next call.
  std::vector<std::pair<std::size_t, State>> changes;
  const std::vector<int> held = HeldNodes(graph);
  for (std::size_t i = begin; i < entries_.size(); ++i) {
    Entry& entry = entries_[i];
    if (entry.state == State::kAccepted) {
      continue;
    }
    // Only those that the new loop can have helped.
    if (i + 1 != entries_.size() && !Compare(entry.loop, loop, graph).agrees) {
      continue;
    }
    const double path = PathToHeld(entry.loop.to, held, graph);
    const State state = StateOf(entry, path, graph);
    changes.emplace_back(i, state);
    constexpr double kRightAfter = 0.25;  // of the scene's depth
    if (state == State::kAccepted && path < kRightAfter * entry.loop.scene_depth) {
      entry.innovation = NormalisedInnovation(entry.loop, graph);
    }
  }
  for (const auto& [i, state] : changes) {
    entries_[i].state = state;
    if (state == State::kAccepted) {
      Believe(&entries_[i], graph);
      believed.push_back(entries_[i]);
    }
  }
  return believed;
}

LoopConsistency::Decision LoopConsistency::Add(const PoseGraphLoop& loop,
                                               int tag,
                                               const PoseGraph& graph) {
  entries_.push_back({loop, tag, State::kPending});
  ForgetOldest(graph);
  const bool are_joined =
      graph.AreJoined(graph.node(loop.from).sequence, graph.node(loop.to).sequence);
  Decision decision;
  decision.believed = are_joined ? Judge(loop, graph) : Join(graph);
  decision.state = entries_.back().state;
  decision.contradicts_join =
      are_joined && decision.state != State::kAccepted && ContradictsJoin(graph);
  return decision;
}

}  // namespace deja_view
