#include "deja_view/pose_graph/pose_graph_problem.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <fmt/format.h>

namespace deja_view {
namespace {

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

std::string PoseGraphProblem::Summary::ToString() const {
  return fmt::format("{} nodes, {} loops: cost {:.4g} -> {:.4g} in {} iterations, {} rounds",
                     nodes,
                     loops,
                     initial_cost,
                     final_cost,
                     iterations,
                     rounds);
}

double PoseGraphProblem::SquaredError(const Edge& edge) const {
  const Node& i = nodes[edge.from];
  const Node& j = nodes[edge.to];
  const std::array<const double*, 4> parameters = {&i.psi, i.t_M_B.data(), &j.psi, j.t_M_B.data()};
  Eigen::Vector4d r;
  FourDofError(edge.measurement).Evaluate(parameters.data(), r.data(), nullptr);
  return r.squaredNorm();
}

void PoseGraphProblem::Weigh(double mu) {
  const double c2 = options.kernel_scale * options.kernel_scale;
  for (Edge& edge : edges) {
    if (edge.loop >= 0) {
      edge.weight = LineProcess(SquaredError(edge), c2, mu);
    }
  }
}

void PoseGraphProblem::Fill(ceres::Problem* problem) {
  for (Node& node : nodes) {
    problem->AddParameterBlock(&node.psi, 1);
    problem->AddParameterBlock(node.t_M_B.data(), 3);
    if (node.is_constant) {
      problem->SetParameterBlockConstant(&node.psi);
      problem->SetParameterBlockConstant(node.t_M_B.data());
    }
  }
  for (const Edge& edge : edges) {
    Node& i = nodes[edge.from];
    Node& j = nodes[edge.to];
    problem->AddResidualBlock(
        std::make_unique<FourDofError>(edge.measurement, std::sqrt(edge.weight)).release(),
        nullptr,
        &i.psi,
        i.t_M_B.data(),
        &j.psi,
        j.t_M_B.data());
  }
}

PoseGraphProblem::Summary PoseGraphProblem::Solve() {
  Summary summary;
  summary.nodes = static_cast<int>(nodes.size());
  double largest = 0;
  for (const Edge& edge : edges) {
    if (edge.loop >= 0) {
      ++summary.loops;
      largest = std::max(largest, SquaredError(edge));
    }
  }
  if (summary.loops == 0) {
    return summary;
  }
  // The Geman-McClure cost is convex in r where r^2 < mu c^2 / 3.
  const double c2 = options.kernel_scale * options.kernel_scale;
  double mu = std::max(1.0, 3.0 * largest / c2);
  bool is_last = false;
  while (!is_last) {
    is_last = mu <= 1.0;
    Weigh(mu);
    ceres::Problem::Options problem_options;
    problem_options.disable_all_safety_checks = true;
    ceres::Problem problem(problem_options);
    Fill(&problem);
    ceres::Solver::Summary result;
    ceres::Solve(SolverOptions(options), &problem, &result);
    summary.initial_cost = summary.rounds == 0 ? result.initial_cost : summary.initial_cost;
    summary.final_cost = result.final_cost;
    summary.iterations += static_cast<int>(result.iterations.size());
    ++summary.rounds;
    mu = std::max(1.0, mu / options.kernel_graduation);
  }
  Weigh(1.0);
  return summary;
}

}  // namespace deja_view
