// Taking back that sequences are joined.
#include "deja_view/base/angles.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

namespace deja_view {
namespace {

/// Which of so many things hang together.
class Components {
 public:
  explicit Components(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t Of(std::size_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  /// False when they are one already.
  bool Join(std::size_t a, std::size_t b) {
    a = Of(a);
    b = Of(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace

std::vector<int> PoseGraph::Separate(int sequence) {
  const auto crosses = [&](int a, int b) {
    return (Record(a).sequence == sequence) != (Record(b).sequence == sequence);
  };
  RehangOnOwn(sequence);
  std::vector<int> gone;
  for (const auto& [id, loop] : loops_) {
    if (crosses(loop.from, loop.to)) {
      gone.push_back(id);
    }
  }
  for (const int id : gone) {
    RemoveLoop(id);
  }
  std::vector<std::pair<int, int>> cut;
  for (const auto& [ends, tie] : ties_) {
    if (crosses(tie.from, tie.to)) {
      cut.push_back(ends);
    }
  }
  for (const auto& [a, b] : cut) {
    RemoveTie(a, b);
  }
  Reconnect();
  Regroup();
  return gone;
}

// Nodes that were dropped beside another sequence's places hang on those.
void PoseGraph::RehangOnOwn(int sequence) {
  std::map<int, std::vector<int>> kept;  // nodes per sequence
  for (const int id : live_) {
    if (Live(id).is_kept) {
      kept[Record(id).sequence].push_back(id);
    }
  }
  for (int i = 0; i < size(); ++i) {
    const Keyframe& k = Record(i);
    const bool is_mine = k.sequence == sequence;
    const auto is_foreign = [&](const Hook& hook) {
      return hook.holder >= 0 && (Record(hook.holder).sequence == sequence) != is_mine;
    };
    if (k.slot < 0 && std::any_of(k.hooks.begin(), k.hooks.end(), is_foreign)) {
      SetHooks(i, kept.at(k.sequence));
    }
  }
}

// Nodes that only another sequence tied to their own have its odometry again.
void PoseGraph::Reconnect() {
  Components components(slots_.size());
  const auto slot = [&](int node) { return static_cast<std::size_t>(Record(node).slot); };
  for (const auto& [ends, tie] : ties_) {
    components.Join(slot(tie.from), slot(tie.to));
  }
  for (std::size_t i = 1; i < live_.size(); ++i) {
    const int from = live_[i - 1];
    const int to = live_[i];
    const bool is_fixed = Record(from).is_fixed && Record(to).is_fixed;
    if (Record(from).sequence == Record(to).sequence && !is_fixed &&
        components.Join(slot(from), slot(to))) {
      AddOdometry(from, to, PathLength(from, to));
    }
  }
}

void PoseGraph::Regroup() {
  const std::vector<int> before = group_;
  Components sequences(group_.size());
  const auto join = [&](int a, int b) {
    sequences.Join(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
  };
  for (std::size_t s = 0; s < map_group_.size(); ++s) {
    join(static_cast<int>(s), map_group_[s]);
  }
  for (const auto& [ends, tie] : ties_) {
    join(Record(tie.from).sequence, Record(tie.to).sequence);
  }
  for (const auto& [id, loop] : loops_) {
    join(Record(loop.from).sequence, Record(loop.to).sequence);
  }
  for (std::size_t s = 0; s < group_.size(); ++s) {
    group_[s] = static_cast<int>(sequences.Of(s));
  }
  for (std::size_t s = 0; s < group_.size(); ++s) {
    const int group = static_cast<int>(s);
    if (group_[s] == group && before[s] != group) {  // its first node holds a world now
      const PoseGraphNode first = node(first_[s]);
      const Eigen::Quaterniond q = FromYaw(-first.psi);
      MoveGroup(group, -first.psi, first.T_W_B.t - q * first.t_M_B);
    }
  }
}

}  // namespace deja_view
