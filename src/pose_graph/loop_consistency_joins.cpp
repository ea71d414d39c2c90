// What joins two worlds, and what tells that it was wrong.
#include "deja_view/pose_graph/loop_consistency.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace deja_view {
namespace {

/// Places that are not within some distance of another one.
class DistinctPlaces {
 public:
  /// False when it is within `near` [m] of one that is known.
  bool Add(const Eigen::Vector3d& place, double near) {
    const bool is_known =
        std::any_of(places_.begin(), places_.end(), [&](const Eigen::Vector3d& other) {
          return (place - other).norm() < near;
        });
    if (!is_known) {
      places_.push_back(place);
    }
    return !is_known;
  }
  int count() const { return static_cast<int>(places_.size()); }

 private:
  std::vector<Eigen::Vector3d> places_;
};

}  // namespace

LoopConsistency::Evidence LoopConsistency::Gather(const Entry& entry,
                                                  const PoseGraph& graph,
                                                  bool with_believed) const {
  Evidence evidence;
  int first = entry.loop.to;
  int last = entry.loop.to;
  const std::size_t begin =
      entries_.size() -
      std::min<std::size_t>(entries_.size(), static_cast<std::size_t>(options_.span_window));
  for (std::size_t i = begin; i < entries_.size(); ++i) {
    const Entry& other = entries_[i];
    if (&other == &entry || (!with_believed && other.state == State::kAccepted)) {
      continue;
    }
    const Comparison c = Compare(entry.loop, other.loop, graph);
    if (!c.is_comparable) {
      continue;
    }
    if (c.rivals) {
      evidence.rivals.push_back(i);
    } else if (c.agrees && other.loop.to != entry.loop.to) {
      evidence.agreeing.push_back(i);
      first = std::min(first, other.loop.to);
      last = std::max(last, other.loop.to);
    }
  }
  evidence.span_m = graph.PathLength(first, last);
  return evidence;
}

int LoopConsistency::CountWitnesses(const std::vector<std::size_t>& entries,
                                    const PoseGraph& graph) const {
  const auto place = [&](int node) { return graph.node(node).T_W_B.t; };
  std::vector<const PoseGraphLoop*> witnesses;
  for (const std::size_t i : entries) {
    const PoseGraphLoop& loop = entries_[i].loop;
    const double near = options_.same_place_over_depth * loop.scene_depth;
    const bool is_known =
        std::any_of(witnesses.begin(), witnesses.end(), [&](const PoseGraphLoop* other) {
          return graph.node(loop.from).sequence == graph.node(other->from).sequence &&
                 (place(loop.from) - place(other->from)).norm() < near &&
                 (place(loop.to) - place(other->to)).norm() < near;
        });
    if (!is_known) {
      witnesses.push_back(&loop);
    }
  }
  return static_cast<int>(witnesses.size());
}

// A drone that stands sees the world from one point, but a map may have seen the same from many.
bool LoopConsistency::DoMapsPlacesSuffice(const std::vector<std::size_t>& entries,
                                          const PoseGraph& graph) const {
  const PoseGraphLoop& newest = entries_.back().loop;
  if (!graph.node(newest.from).is_fixed) {
    return false;
  }
  const Eigen::Vector3d newest_place = graph.node(newest.from).T_M_B().t;
  DistinctPlaces places;
  double span_m = 0;
  for (const std::size_t i : entries) {
    const Eigen::Vector3d place = graph.node(entries_[i].loop.from).T_M_B().t;
    if (places.Add(place, options_.same_place_over_depth * entries_[i].loop.scene_depth)) {
      span_m = std::max(span_m, (place - newest_place).norm());
    }
  }
  return places.count() >= options_.min_support_join &&
         span_m >= options_.min_span_over_depth * newest.scene_depth;
}

bool LoopConsistency::Suffices(const Evidence& evidence, const PoseGraph& graph) const {
  const int support = CountWitnesses(evidence.agreeing, graph);
  const double wanted_m = options_.min_span_over_depth * entries_.back().loop.scene_depth;
  const bool is_spread =
      evidence.span_m >= wanted_m || DoMapsPlacesSuffice(evidence.agreeing, graph);
  return support >= options_.min_support_join && is_spread &&
         CountWitnesses(evidence.rivals, graph) <= options_.max_rival_ratio * support;
}

// The newest loop joins two worlds together with those that agree with it, or waits.
std::vector<LoopConsistency::Entry> LoopConsistency::Join(const PoseGraph& graph) {
  const Evidence evidence = Gather(entries_.back(), graph);
  if (!Suffices(evidence, graph)) {
    return {};
  }
  std::vector<Entry> believed;
  const auto believe = [&](Entry* entry) {
    if (entry->state != State::kAccepted) {
      Believe(entry, graph);
      believed.push_back(*entry);
    }
  };
  for (const std::size_t i : AgreeingAmongThemselves(evidence.agreeing, graph)) {
    believe(&entries_[i]);
  }
  believe(&entries_.back());
  return believed;
}

// Whether the newest loop would join the worlds if those that are believed did not, and better.
bool LoopConsistency::ContradictsJoin(const PoseGraph& graph) const {
  const PoseGraphLoop& newest = entries_.back().loop;
  const int sequence = graph.node(newest.to).sequence;
  if (graph.node(newest.from).sequence == sequence) {
    return false;
  }
  const Evidence evidence = Gather(entries_.back(), graph, false);
  if (!Suffices(evidence, graph)) {
    return false;
  }
  const double near = options_.same_place_over_depth * newest.scene_depth;
  DistinctPlaces refused;
  refused.Add(graph.node(newest.from).t_M_B, near);
  for (const std::size_t i : evidence.agreeing) {
    refused.Add(graph.node(entries_[i].loop.from).t_M_B, near);
  }
  DistinctPlaces believed;
  for (const auto& [sequences, places] : joining_) {
    for (const auto& [place, count] : places) {
      if (sequences.second == sequence && believed.count() < refused.count()) {
        believed.Add(graph.node(place).t_M_B, near);
      }
    }
  }
  return believed.count() < refused.count();
}

// The newest loop may be so uncertain that it agrees with nearly all.
std::vector<std::size_t> LoopConsistency::AgreeingAmongThemselves(
    const std::vector<std::size_t>& entries, const PoseGraph& graph) const {
  std::vector<std::size_t> agreeing;
  for (const std::size_t i : entries) {
    int support = 1;  // the newest loop
    int against = 0;
    for (const std::size_t k : entries) {
      const Comparison c =
          k == i ? Comparison{} : Compare(entries_[i].loop, entries_[k].loop, graph);
      support += c.is_comparable && c.agrees ? 1 : 0;
      against += c.is_comparable && !c.agrees ? 1 : 0;
    }
    if (against <= support) {
      agreeing.push_back(i);
    }
  }
  return agreeing;
}

LoopConsistency::Decision LoopConsistency::Reconsider(const PoseGraph& graph) {
  Decision decision;
  decision.believed = Join(graph);
  decision.state = entries_.back().state;
  return decision;
}

void LoopConsistency::Separate(int sequence, const PoseGraph& graph) {
  const auto joins_it = [&](const std::pair<int, int>& sequences) {
    return (sequences.first == sequence) != (sequences.second == sequence);
  };
  entries_.erase(std::remove_if(entries_.begin(),
                                entries_.end(),
                                [&](const Entry& entry) {
                                  return entry.state == State::kAccepted &&
                                         joins_it({graph.node(entry.loop.from).sequence,
                                                   graph.node(entry.loop.to).sequence});
                                }),
                 entries_.end());
  for (auto it = joining_.begin(); it != joining_.end();) {
    it = joins_it(it->first) ? joining_.erase(it) : std::next(it);
  }
}

}  // namespace deja_view
