#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace ceres {
class Problem;
}

namespace deja_view {

struct PoseGraphOptions {
  // VIO's drift as a random walk between consecutive keyframes.
  double odometry_sigma_floor_m = 0.001;           ///< [m] per step
  double odometry_sigma_per_sqrt_m = 0.018;        ///< [m / sqrt(m)]
  double odometry_yaw_sigma_floor_deg = 0.005;     ///< [deg] per step
  double odometry_yaw_sigma_per_sqrt_m_deg = 0.2;  ///< [deg / sqrt(m)]
  // What a loop's own covariance does not know: common errors of the points (scale, window drift).
  double loop_sigma_floor_m = 0.01;  ///< [m] per axis
  double loop_sigma_per_m = 0.005;   ///< [m/m] more per metre between the two bodies
  double loop_scale_sigma = 0.05;    ///< of the distance: the scale of the VIO's points wavers
  double loop_yaw_sigma_floor_deg = 0.15;  ///< [deg]
  double kernel_scale = 3.0;               ///< [sigma] of the Geman-McClure kernel on loops
  double kernel_graduation = 2.0;          ///< factor by which the kernel narrows per round, > 1
  int max_iterations = 10;                 ///< of the solver, per round

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("odometry_sigma_floor_m", odometry_sigma_floor_m);
    v("odometry_sigma_per_sqrt_m", odometry_sigma_per_sqrt_m);
    v("odometry_yaw_sigma_floor_deg", odometry_yaw_sigma_floor_deg);
    v("odometry_yaw_sigma_per_sqrt_m_deg", odometry_yaw_sigma_per_sqrt_m_deg);
    v("loop_sigma_floor_m", loop_sigma_floor_m);
    v("loop_sigma_per_m", loop_sigma_per_m);
    v("loop_scale_sigma", loop_scale_sigma);
    v("loop_yaw_sigma_floor_deg", loop_yaw_sigma_floor_deg);
    v("kernel_scale", kernel_scale);
    v("kernel_graduation", kernel_graduation);
    v("max_iterations", max_iterations);
  }
  std::vector<std::string> Validate() const;
};

/// A keyframe of the graph.
struct PoseGraphNode {
  int sequence = 0;
  bool is_fixed = false;  ///< part of a loaded map: never moves
  Rigid3 T_W_B;           ///< as received from the VIO
  double psi = 0;         ///< [rad] correction about the map's z: R_M_B = Rz(psi) R_W_B
  Eigen::Vector3d t_M_B = Eigen::Vector3d::Zero();  ///< [m]

  Rigid3 T_M_B() const { return {(FromYaw(psi) * T_W_B.q).normalized(), t_M_B}; }
};

/// A loop constraint between two nodes, `from` the older one.
struct PoseGraphLoop {
  int from = -1;
  int to = -1;
  Rigid3 T_from_to;  ///< measured [m]
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Identity();  ///< of (t, rotation vector) in frame `from`
  double scene_depth = 5.0;  ///< [m] median distance of the points it rests on: the scene's scale
  double weight = 1.0;       ///< line process of the robust kernel after the last solve, in [0, 1]
};

/// 4-DoF pose graph over keyframes: a chain of odometry edges per sequence, loops between any two
/// nodes. The first node of the map is the anchor. Sequences that no loop joins to the anchor's
/// keep a world of their own, held by their first node. A value: copy it to solve a snapshot
/// elsewhere.
class PoseGraph {
 public:
  explicit PoseGraph(const PoseGraphOptions& options) : options_(options) {}

  /// A graph from saved parts, each node where it is; the loops tell which sequences are joined.
  static PoseGraph FromParts(const PoseGraphOptions& options,
                             std::vector<PoseGraphNode> nodes,
                             std::vector<PoseGraphLoop> loops);

  /// Appends a node; it starts where the drift of the node before it (same sequence) puts it.
  int AddNode(int sequence, const Rigid3& T_W_B, bool is_fixed = false);
  /// Adds a loop; both nodes must exist. The first loop between two unjoined groups of sequences
  /// moves the group without the anchor rigidly (yaw and translation) into place.
  void AddLoop(const PoseGraphLoop& loop);
  /// Replaces the measurement of an existing loop; false when there is none between the two.
  bool UpdateLoop(int from, int to, const Rigid3& T_from_to);

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

  /// Takes over the solution of a solved snapshot of this graph: its nodes' states and loop
  /// weights; nodes added since keep their odometry to the snapshot's last node of their sequence.
  void TakeSolution(const PoseGraph& snapshot);

  int size() const { return static_cast<int>(nodes_.size()); }
  const std::vector<PoseGraphNode>& nodes() const { return nodes_; }
  const std::vector<PoseGraphLoop>& loops() const { return loops_; }
  const PoseGraphOptions& options() const { return options_; }

  /// T_M_W of the node: takes its VIO world to the map.
  Rigid3 Correction(int node) const;
  /// True when a chain of loops ties the sequence to the anchor.
  bool IsAnchored(int sequence) const;
  /// True when a chain of loops ties the two sequences to each other.
  /// Covariance [m^2] of a loop's translation beyond its own: common errors of its points.
  Eigen::Matrix3d LoopCommonCovariance(const Eigen::Vector3d& t_from_to) const;
  bool AreJoined(int a, int b) const { return Group(a) == Group(b); }
  /// Root-information-weighted squared error of a loop at the present state (chi-squared, 4
  /// degrees).
  double SquaredError(const PoseGraphLoop& loop) const;
  /// Path length [m] along the VIO between two nodes of one sequence.
  double PathLength(int from, int to) const;

 private:
  Eigen::Matrix4d LoopSqrtInformation(const PoseGraphLoop& loop) const;
  Eigen::Matrix4d OdometrySqrtInformation(double distance) const;
  /// Parameters and residuals of one round, loops weighted by a kernel `mu` times wider than the
  /// final one.
  void FillProblem(double mu, ceres::Problem* problem);
  void JoinGroups(const PoseGraphLoop& loop);
  int Group(int sequence) const;

  PoseGraphOptions options_;
  std::vector<PoseGraphNode> nodes_;
  std::vector<double> path_;  ///< [m] travelled up to each node within its sequence
  std::vector<int> group_;    ///< per sequence: the lowest sequence it is joined to
  std::vector<PoseGraphLoop> loops_;
};

}  // namespace deja_view
