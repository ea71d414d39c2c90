// What of a pose graph is solved, and what becomes of the solution.
#include "deja_view/base/check.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <algorithm>
#include <deque>
#include <vector>

namespace deja_view {

FourDofError::Measurement PoseGraph::Measurement(const PoseGraphTie& tie) const {
  FourDofError::Measurement m;
  m.t_I_J = tie.t_I_J;
  m.delta_psi = tie.delta_psi;
  m.R_W_I = Eigen::Quaterniond(Record(tie.from).q_W_B).toRotationMatrix();
  m.sqrt_information = tie.information.llt().matrixU();
  return m;
}

FourDofError::Measurement PoseGraph::Measurement(const PoseGraphLoop& loop) const {
  const Eigen::Quaterniond q_W_I(Record(loop.from).q_W_B);
  FourDofError::Measurement m;
  m.t_I_J = loop.T_from_to.t;
  m.delta_psi = DeltaPsi(q_W_I, loop.T_from_to.q, Eigen::Quaterniond(Record(loop.to).q_W_B));
  m.R_W_I = q_W_I.toRotationMatrix();
  m.sqrt_information = LoopSqrtInformation(loop);
  return m;
}

// The first node of a group of sequences holds its world.
bool PoseGraph::IsConstant(int node) const {
  const Keyframe& k = Record(node);
  return k.is_fixed || first_[static_cast<std::size_t>(Group(k.sequence))] == node;
}

// Breadth first from the nodes that are no places, the newest first.
std::vector<int> PoseGraph::Scope(std::size_t most) const {
  if (live_.size() <= most) {
    return live_;
  }
  std::vector<bool> is_seen(slots_.size(), false);
  std::deque<int> queue;
  std::vector<int> scope;
  const auto see = [&](int node) {
    if (!is_seen[static_cast<std::size_t>(Record(node).slot)]) {
      is_seen[static_cast<std::size_t>(Record(node).slot)] = true;
      queue.push_back(node);
    }
  };
  std::for_each(window_.rbegin(), window_.rend(), see);
  while (!queue.empty() && scope.size() < most) {
    const int node = queue.front();
    queue.pop_front();
    scope.push_back(node);
    std::for_each(Live(node).neighbours.begin(), Live(node).neighbours.end(), see);
    for (const int id : Live(node).loops) {
      see(loop(id).from);
      see(loop(id).to);
    }
  }
  std::sort(scope.begin(), scope.end());
  return scope;
}

PoseGraphProblem PoseGraph::Problem(std::size_t most) const {
  PoseGraphProblem problem;
  problem.options = options_;
  problem.graph_size = size();
  problem.groups = group_;
  AddEdges(Scope(most), &problem);
  return problem;
}

void PoseGraph::AddEdges(const std::vector<int>& scope, PoseGraphProblem* problem) const {
  std::vector<int> index(slots_.size(), -1);
  const auto node_of = [&](int id, bool is_constant) {
    int& i = index[static_cast<std::size_t>(Record(id).slot)];
    if (i < 0) {
      i = static_cast<int>(problem->nodes.size());
      const PoseGraphNode& node = Live(id).node;
      problem->nodes.push_back({id, is_constant, node.psi, node.t_M_B});
    }
    return static_cast<std::size_t>(i);
  };
  std::vector<bool> is_free(slots_.size(), false);
  for (const int id : scope) {
    if (!IsConstant(id)) {
      is_free[static_cast<std::size_t>(Record(id).slot)] = true;
      node_of(id, false);
    }
  }
  const auto is_free_node = [&](int id) {
    return static_cast<bool>(is_free[static_cast<std::size_t>(Record(id).slot)]);
  };
  // Each edge once: at its younger free end.
  const auto add = [&](int id, const auto& edge, int loop, double weight) {
    const int other = edge.from == id ? edge.to : edge.from;
    if (!is_free_node(other) || other < id) {
      const std::size_t from = node_of(edge.from, !is_free_node(edge.from));
      const std::size_t to = node_of(edge.to, !is_free_node(edge.to));
      problem->edges.push_back({from, to, Measurement(edge), loop, weight});
    }
  };
  for (const int id : scope) {
    if (!is_free_node(id)) {
      continue;
    }
    for (const int other : Live(id).neighbours) {
      add(id, ties_.at({std::min(id, other), std::max(id, other)}), -1, 1.0);
    }
    for (const int loop_id : Live(id).loops) {
      add(id, loop(loop_id), loop_id, loop(loop_id).weight);
    }
  }
}

PoseGraph::Summary PoseGraph::Solve() {
  PoseGraphProblem problem = Problem();
  const Summary summary = problem.Solve();
  TakeSolution(problem);
  return summary;
}

void PoseGraph::TakeSolution(const PoseGraphProblem& solved) {
  DEJA_VIEW_CHECK_OP(solved.graph_size, <=, size());
  // Sequences that were joined to others since stay where that has put them.
  const auto was_solved = [&](int sequence) {
    const auto s = static_cast<std::size_t>(sequence);
    return s < solved.groups.size() && solved.groups[s] == Group(sequence);
  };
  for (const PoseGraphProblem::Node& node : solved.nodes) {
    if (!node.is_constant && was_solved(Record(node.id).sequence)) {
      PoseGraphNode& mine = Live(node.id).node;
      mine.psi = node.psi;
      mine.t_M_B = node.t_M_B;
    }
  }
  for (int i = std::max(1, solved.graph_size); i < size(); ++i) {
    PoseGraphNode& node = Live(i).node;
    if (was_solved(node.sequence) && Record(i - 1).sequence == node.sequence) {
      node.psi = this->node(i - 1).psi;
      node.t_M_B = Correction(i - 1) * node.T_W_B.t;
    }
  }
  for (const PoseGraphProblem::Edge& edge : solved.edges) {
    if (edge.loop >= 0) {
      PoseGraphLoop& loop = loops_.at(edge.loop);
      loop.weight = edge.weight;
      loop.contradicted = edge.weight < options_.withdraw_weight ? loop.contradicted + 1 : 0;
    }
  }
}

}  // namespace deja_view
