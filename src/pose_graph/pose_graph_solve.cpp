#include "deja_view/pose_graph/four_dof_error.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <fmt/format.h>

namespace deja_view {
namespace {

FourDofError::Measurement OdometryMeasurement(const PoseGraphNode& i, const PoseGraphNode& j) {
  FourDofError::Measurement m;
  m.t_I_J = i.T_W_B.q.conjugate() * (j.T_W_B.t - i.T_W_B.t);
  m.R_W_I = i.T_W_B.R();
  return m;
}

FourDofError::Measurement LoopMeasurement(const PoseGraphLoop& loop,
                                          const PoseGraphNode& i,
                                          const PoseGraphNode& j) {
  FourDofError::Measurement m;
  m.t_I_J = loop.T_from_to.t;
  m.delta_psi = DeltaPsi(i.T_W_B.q, loop.T_from_to.q, j.T_W_B.q);
  m.R_W_I = i.T_W_B.R();
  return m;
}

ceres::Solver::Options SolverOptions(const PoseGraphOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-5;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.initial_trust_region_radius = 1e8;
  return solver;
}

/// Geman-McClure line process for the squared error r2 [sigma^2] and a kernel `mu` times wider than
/// c.
double LineProcess(double r2, double c2, double mu) {
  const double w = mu * c2 / (r2 + mu * c2);
  return w * w;
}

}  // namespace

std::string PoseGraph::Summary::ToString() const {
  return fmt::format("{} nodes, {} loops: cost {:.4g} -> {:.4g} in {} iterations, {} rounds",
                     nodes,
                     loops,
                     initial_cost,
                     final_cost,
                     iterations,
                     rounds);
}

void PoseGraph::FillProblem(double mu, ceres::Problem* problem) {
  const double c2 = options_.kernel_scale * options_.kernel_scale;
  std::vector<bool> has_anchor(group_.size(), false);
  for (PoseGraphNode& node : nodes_) {
    problem->AddParameterBlock(&node.psi, 1);
    problem->AddParameterBlock(node.t_M_B.data(), 3);
    const auto group = static_cast<std::size_t>(Group(node.sequence));
    if (node.is_fixed || !has_anchor[group]) {
      has_anchor[group] = true;
      problem->SetParameterBlockConstant(&node.psi);
      problem->SetParameterBlockConstant(node.t_M_B.data());
    }
  }
  const auto add = [&](int from, int to, const FourDofError::Measurement& m, double weight) {
    PoseGraphNode& i = nodes_[static_cast<std::size_t>(from)];
    PoseGraphNode& j = nodes_[static_cast<std::size_t>(to)];
    problem->AddResidualBlock(std::make_unique<FourDofError>(m, weight).release(),
                              nullptr,
                              &i.psi,
                              i.t_M_B.data(),
                              &j.psi,
                              j.t_M_B.data());
  };
  for (int i = 1; i < size(); ++i) {
    const PoseGraphNode& a = nodes_[static_cast<std::size_t>(i - 1)];
    const PoseGraphNode& b = nodes_[static_cast<std::size_t>(i)];
    if (a.sequence == b.sequence && !(a.is_fixed && b.is_fixed)) {
      auto m = OdometryMeasurement(a, b);
      m.sqrt_information = OdometrySqrtInformation(m.t_I_J.norm());
      add(i - 1, i, m, 1.0);
    }
  }
  for (PoseGraphLoop& loop : loops_) {
    const PoseGraphNode& i = nodes_[static_cast<std::size_t>(loop.from)];
    const PoseGraphNode& j = nodes_[static_cast<std::size_t>(loop.to)];
    if (!(i.is_fixed && j.is_fixed)) {
      loop.weight = LineProcess(SquaredError(loop), c2, mu);
      auto m = LoopMeasurement(loop, i, j);
      m.sqrt_information = LoopSqrtInformation(loop);
      add(loop.from, loop.to, m, std::sqrt(loop.weight));
    }
  }
}

PoseGraph::Summary PoseGraph::Solve() {
  Summary summary;
  double largest = 0;
  for (const PoseGraphLoop& loop : loops_) {
    largest = std::max(largest, SquaredError(loop));
  }
  if (loops_.empty()) {
    return summary;
  }
  // The Geman-McClure cost is convex in r where r^2 < mu c^2 / 3.
  const double c2 = options_.kernel_scale * options_.kernel_scale;
  double mu = std::max(1.0, 3.0 * largest / c2);
  bool is_last = false;
  while (!is_last) {
    is_last = mu <= 1.0;
    ceres::Problem::Options problem_options;
    problem_options.disable_all_safety_checks = true;
    ceres::Problem problem(problem_options);
    FillProblem(mu, &problem);
    ceres::Solver::Summary result;
    ceres::Solve(SolverOptions(options_), &problem, &result);
    summary.initial_cost = summary.rounds == 0 ? result.initial_cost : summary.initial_cost;
    summary.final_cost = result.final_cost;
    summary.iterations += static_cast<int>(result.iterations.size());
    ++summary.rounds;
    mu = std::max(1.0, mu / options_.kernel_graduation);
  }
  summary.nodes = size();
  summary.loops = static_cast<int>(loops_.size());
  return summary;
}

}  // namespace deja_view
