#pragma once

#include "deja_view/pose_graph/four_dof_error.hpp"
#include "deja_view/pose_graph/pose_graph_parts.hpp"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace ceres {
class Problem;
}

namespace deja_view {

/// A pose graph's least squares problem, or that of some of its nodes, apart from the graph: to be
/// solved elsewhere while the graph grows.
struct PoseGraphProblem {
  struct Node {
    int id = -1;
    bool is_constant = false;
    double psi = 0;                                   ///< [rad]
    Eigen::Vector3d t_M_B = Eigen::Vector3d::Zero();  ///< [m]
  };
  struct Edge {
    std::size_t from = 0;  ///< indices of `nodes`
    std::size_t to = 0;
    FourDofError::Measurement measurement;
    int loop = -1;        ///< id of the loop; -1: a tie, which no kernel doubts
    double weight = 1.0;  ///< line process of the robust kernel after Solve, in [0, 1]
  };
  struct Summary {
    int nodes = 0;
    int loops = 0;
    int iterations = 0;
    int rounds = 0;
    double initial_cost = 0;
    double final_cost = 0;
    std::string ToString() const;
  };

  /// Minimises odometry and loop errors with Ceres and a graduated Geman-McClure kernel on the
  /// loops (graduated non-convexity; Yang et al., RA-L 2020): it starts wide enough to be convex
  /// for the largest present loop error and narrows to `kernel_scale`. One thread, deterministic.
  Summary Solve();

  PoseGraphOptions options;
  std::vector<Node> nodes;
  std::vector<Edge> edges;
  int graph_size = 0;       ///< nodes that the graph had
  std::vector<int> groups;  ///< per sequence: the lowest sequence it was joined to

 private:
  double SquaredError(const Edge& edge) const;
  /// Sets the loops' weights by a kernel `mu` times wider than the final one.
  void Weigh(double mu);
  void Fill(ceres::Problem* problem);
};

}  // namespace deja_view
