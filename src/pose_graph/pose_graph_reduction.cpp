// Nodes and loops that a pose graph need not keep.
#include "deja_view/base/check.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "segment_marginal.hpp"

namespace deja_view {

double PoseGraph::KernelWeight(const PoseGraphLoop& loop) const {
  const double c2 = options_.kernel_scale * options_.kernel_scale;
  return std::pow(c2 / (SquaredError(loop) + c2), 2);
}

std::vector<int> PoseGraph::WithdrawContradicted(int after) {
  std::vector<int> withdrawn;
  for (const auto& [id, loop] : loops_) {
    if (loop.contradicted >= after) {
      withdrawn.push_back(id);
    }
  }
  for (const int id : withdrawn) {
    RemoveLoop(id);
  }
  return withdrawn;
}

PoseGraph::Settled PoseGraph::Reduce() {
  constexpr std::size_t kMostAtOnce = 64;  // the marginal of a segment takes the cube of its nodes
  Settled settled;
  const auto window = static_cast<std::size_t>(options_.window);
  if (window == 0 || window_.size() < window + window / 4 + 1) {
    return settled;
  }
  while (window_.size() > window) {
    const std::size_t count = std::min(kMostAtOnce, window_.size() - window);
    const std::vector<int> oldest(window_.begin(),
                                  window_.begin() + static_cast<std::ptrdiff_t>(count));
    window_.erase(window_.begin(), window_.begin() + static_cast<std::ptrdiff_t>(count));
    for (const int node : oldest) {
      SettleLoops(Live(node).loops, &settled);
    }
    DropAll(oldest);
  }
  std::vector<int> of_places;
  for (const auto& [id, loop] : loops_) {
    if (loop.from < window_.front() && loop.to < window_.front()) {
      of_places.push_back(id);
    }
  }
  const std::size_t before = settled.absorbed.size();
  SettleLoops(of_places, &settled);
  for (std::size_t i = before; i < settled.absorbed.size(); ++i) {
    Absorb(settled.absorbed[i]);
  }
  return settled;
}

void PoseGraph::SettleLoops(const std::vector<int>& ids, Settled* settled) {
  for (const int id : std::vector<int>(ids)) {
    PoseGraphLoop& loop = loops_.at(id);
    loop.weight = KernelWeight(loop);
    if (loop.weight < options_.withdraw_weight) {
      RemoveLoop(id);
      settled->withdrawn.push_back(id);
    } else {
      settled->absorbed.push_back(id);
    }
  }
}

void PoseGraph::Absorb(int id) {
  PoseGraphLoop loop = loops_.at(id);
  RemoveLoop(id);
  if (Record(loop.from).is_fixed && Record(loop.to).is_fixed) {
    return;
  }
  if (loop.from > loop.to) {
    Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = loop.T_from_to.R().transpose();
    loop.covariance = turn * loop.covariance * turn.transpose();
    loop.T_from_to = loop.T_from_to.Inverse();
    std::swap(loop.from, loop.to);
  }
  const FourDofError::Measurement m = Measurement(loop);
  AddTie({loop.from,
          loop.to,
          m.t_I_J,
          m.delta_psi,
          loop.weight * m.sqrt_information.transpose() * m.sqrt_information});
}

std::set<int> PoseGraph::Around(int node) const {
  std::set<int> around(Live(node).neighbours.begin(), Live(node).neighbours.end());
  for (const int id : Live(node).loops) {
    around.insert(loop(id).from == node ? loop(id).to : loop(id).from);
  }
  return around;
}

// Nodes that hang together go together.
void PoseGraph::DropAll(const std::vector<int>& nodes) {
  std::vector<int> left = nodes;
  while (!left.empty()) {
    std::vector<int> segment = {left.front()};
    left.erase(left.begin());
    for (std::size_t i = 0; i < segment.size(); ++i) {
      for (const int other : Around(segment[i])) {
        const auto it = std::find(left.begin(), left.end(), other);
        if (it != left.end()) {
          segment.push_back(other);
          left.erase(it);
        }
      }
    }
    DropSegment(segment);
  }
}

void PoseGraph::DropSegment(const std::vector<int>& dropped) {
  Segment segment;
  std::map<int, std::size_t> index;
  const auto index_of = [&](int id, bool is_dropped) {
    const auto [it, is_new] = index.try_emplace(id, segment.nodes.size());
    if (is_new) {
      segment.nodes.push_back({id, Live(id).node, is_dropped});
    }
    return it->second;
  };
  for (const int node : dropped) {
    index_of(node, true);
  }
  for (const int node : dropped) {
    for (const int other : std::vector<int>(Live(node).neighbours)) {
      const PoseGraphTie& tie = ties_.at({std::min(node, other), std::max(node, other)});
      segment.edges.push_back(
          {index_of(tie.from, false), index_of(tie.to, false), Measurement(tie)});
      RemoveTie(node, other);
    }
    for (const int id : std::vector<int>(Live(node).loops)) {
      const PoseGraphLoop& loop = this->loop(id);
      segment.edges.push_back(
          {index_of(loop.from, false), index_of(loop.to, false), Measurement(loop)});
      segment.edges.back().measurement.sqrt_information *= std::sqrt(loop.weight);
      RemoveLoop(id);
    }
  }
  std::vector<int> holders;
  for (const Segment::Node& node : segment.nodes) {
    if (!node.is_dropped && Live(node.id).is_kept) {
      holders.push_back(node.id);
    }
  }
  for (const int node : dropped) {
    Hang(node, holders);
  }
  for (const PoseGraphTie& tie : Marginalise(segment)) {
    AddTie(tie);
  }
}

PoseGraph::Hook PoseGraph::MakeHook(const PoseGraphNode& hung,
                                    int holder,
                                    const PoseGraphNode& stays) {
  return {
      holder, WrapAngle(hung.psi - stays.psi), FromYaw(-stays.psi) * (hung.t_M_B - stays.t_M_B)};
}

void PoseGraph::SetHooks(int node, std::vector<int> holders) {
  DEJA_VIEW_CHECK(!holders.empty());
  const PoseGraphNode hung = this->node(node);
  const auto distance = [&](int holder) { return (Live(holder).node.t_M_B - hung.t_M_B).norm(); };
  const std::size_t count = std::min<std::size_t>(2, holders.size());
  std::partial_sort(holders.begin(),
                    holders.begin() + static_cast<std::ptrdiff_t>(count),
                    holders.end(),
                    [&](int a, int b) {
                      return std::make_pair(distance(a), a) < std::make_pair(distance(b), b);
                    });
  Keyframe& k = keyframes_.at(static_cast<std::size_t>(node));
  k.hooks = {};
  k.hooks[0] = MakeHook(hung, holders[0], Live(holders[0]).node);
  if (count == 2) {
    k.hooks[1] = MakeHook(hung, holders[1], Live(holders[1]).node);
    const double near = distance(holders[0]);
    const double far = distance(holders[1]);
    k.share = static_cast<float>(far > 0 ? near / (near + far) : 0.5);
  }
}

void PoseGraph::Hang(int node, std::vector<int> holders) {
  SetHooks(node, std::move(holders));
  Keyframe& k = keyframes_.at(static_cast<std::size_t>(node));
  Live(node) = Slot();
  free_slots_.push_back(k.slot);
  k.slot = -1;
  live_.erase(std::lower_bound(live_.begin(), live_.end(), node));
}

}  // namespace deja_view
