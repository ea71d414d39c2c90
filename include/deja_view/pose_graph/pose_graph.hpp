#pragma once

#include "deja_view/pose_graph/pose_graph_parts.hpp"
#include "deja_view/pose_graph/pose_graph_problem.hpp"

#include <array>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// 4-DoF pose graph over keyframes: a chain of odometry per sequence, loops between any two nodes.
/// The first node of the map is the anchor. Sequences that no loop joins to the anchor's keep a
/// world of their own, held by their first node.
///
/// It grows with the space that is flown through, not with time, as the reduced pose graph of
/// Johannsson et al. (Temporally scalable visual SLAM using a reduced pose graph, ICRA 2013): the
/// nodes that stay are places, the first of each sequence, and the newest few. Reduce drops the
/// others with the information kept: a stretch of them is marginalised, and what the nodes around
/// it thereby know of each other is kept as the tree of relative poses that keeps most of it
/// (Kretzschmar and Stachniss, Information-theoretic compression of pose graphs, IJRR 2012; in
/// closed form for a tree: Mazuran et al., Nonlinear factor recovery, IJRR 2016). These and not a
/// fixed lag, since a drone that comes back after an hour must find the map still free to bend. A
/// dropped node keeps its pose relative to the nearest two that stay.
class PoseGraph {
 public:
  explicit PoseGraph(const PoseGraphOptions& options) : options_(options) {}

  struct Part {
    PoseGraphNode node;
    bool is_kept = true;  ///< a place; else, where it is fixed, it is dropped at once
  };
  /// A graph from saved parts, each node where it is; the loops tell which sequences are joined.
  /// Loops between two fixed nodes have told all by that, and are no loops of the graph.
  static PoseGraph FromParts(const PoseGraphOptions& options,
                             const std::vector<Part>& parts,
                             const std::vector<PoseGraphLoop>& loops);

  /// Appends a node; it starts where the drift of the node before it (same sequence) puts it.
  int AddNode(int sequence, const Rigid3& T_W_B, bool is_fixed = false);
  /// The node is a place: it stays for ever.
  void Keep(int node);
  /// Adds a loop; both nodes must have been added. The first loop between two unjoined groups of
  /// sequences moves the group without the anchor rigidly (yaw and translation) into place. A loop
  /// with a dropped node becomes one with the node that it hangs on. Returns the loop's id, which
  /// counts up.
  int AddLoop(const PoseGraphLoop& loop);
  /// Replaces the measurement of a loop.
  void UpdateLoop(int id, const Rigid3& T_from_to);
  void RemoveLoop(int id);
  /// Takes back that a sequence is joined to others: its loops and ties with them go, and its first
  /// node holds a world of its own again. Others that only it joined come apart, too. Within a
  /// sequence all stay where they are, and what dropped nodes knew stays in the ties. Returns the
  /// ids of the loops that are gone. A solution that is under way must not be taken over.
  std::vector<int> Separate(int sequence);

  using Summary = PoseGraphProblem::Summary;
  /// Solves everything.
  Summary Solve();

  /// The problem of at most `most` nodes: the newest, and those that are tied to them over the
  /// fewest ties and loops; the nodes around them are constant.
  PoseGraphProblem Problem(std::size_t most = std::numeric_limits<std::size_t>::max()) const;
  /// Takes over a solution: states and loop weights; nodes added since keep their odometry to the
  /// problem's last node of their sequence.
  void TakeSolution(const PoseGraphProblem& solved);

  /// Loops by what became of them, by id.
  struct Settled {
    std::vector<int> absorbed;   ///< part of the ties now, and no loops any more
    std::vector<int> withdrawn;  ///< contradicted, and gone
  };
  /// Drops nodes that are no places and older than the newest `window` of such. Their loops, and
  /// those of places as old, are absorbed, or withdrawn when the last solution switched them off.
  /// Call it only when the graph has been solved since their loops were added.
  Settled Reduce();
  /// Withdraws the loops that `after` solutions in a row have switched off.
  std::vector<int> WithdrawContradicted(int after);

  /// Nodes ever added.
  int size() const { return static_cast<int>(keyframes_.size()); }
  /// Those that take part in solving.
  std::size_t live_size() const { return live_.size(); }
  /// Those that are dropped one day.
  std::size_t window_size() const { return window_.size(); }
  PoseGraphNode node(int i) const;
  const std::map<int, PoseGraphLoop>& loops() const { return loops_; }  ///< by id
  const PoseGraphLoop& loop(int id) const { return loops_.at(id); }
  const std::map<std::pair<int, int>, PoseGraphTie>& ties() const { return ties_; }
  const PoseGraphOptions& options() const { return options_; }
  bool IsLive(int node) const { return Record(node).slot >= 0; }

  /// T_M_W of the node: takes its VIO world to the map.
  Rigid3 Correction(int node) const;
  /// True when a chain of loops ties the sequence to the anchor.
  bool IsAnchored(int sequence) const;
  /// True when the graph was made with the two sequences joined: a map's poses are of one world.
  bool AreJoinedInMap(int a, int b) const;
  /// True when a chain of loops ties the two sequences to each other.
  bool AreJoined(int a, int b) const { return Group(a) == Group(b); }
  /// Covariance [m^2] of a loop's translation beyond its own: common errors of its points.
  Eigen::Matrix3d LoopCommonCovariance(const Eigen::Vector3d& t_from_to) const;
  /// Root-information-weighted squared error of a loop at the present state (chi-squared, 4
  /// degrees).
  double SquaredError(const PoseGraphLoop& loop) const;
  /// Path length [m] along the VIO between two nodes of one sequence.
  double PathLength(int from, int to) const;
  /// Path length [m] along the VIO from the first node of its sequence.
  double PathFromStart(int node) const { return Record(node).path; }

 private:
  /// Where a dropped node is as seen from one that stays.
  struct Hook {
    int holder = -1;
    double psi = 0;                               ///< [rad]
    Eigen::Vector3d t = Eigen::Vector3d::Zero();  ///< [m]
  };
  /// Of every node ever added.
  struct Keyframe {
    Eigen::Vector4d q_W_B = Eigen::Vector4d::UnitW();  ///< x, y, z, w
    Eigen::Vector3d t_W_B = Eigen::Vector3d::Zero();   ///< [m]
    double path = 0;                                   ///< [m] travelled within its sequence
    std::array<Hook, 2> hooks;                         ///< once dropped; the second one need not be
    float share = 0;                                   ///< of the second one
    int sequence = 0;
    int slot = -1;  ///< of slots_; below 0: dropped
    bool is_fixed = false;
  };
  struct Slot {
    PoseGraphNode node;
    bool is_kept = false;
    std::vector<int> neighbours;  ///< nodes that it has a tie to
    std::vector<int> loops;
  };

  const Keyframe& Record(int node) const { return keyframes_.at(static_cast<std::size_t>(node)); }
  Slot& Live(int node) { return slots_.at(static_cast<std::size_t>(Record(node).slot)); }
  const Slot& Live(int node) const {
    return slots_.at(static_cast<std::size_t>(Record(node).slot));
  }
  int TakeSlot();
  PoseGraphLoop WithLiveEnds(PoseGraphLoop loop) const;
  FourDofError::Measurement Measurement(const PoseGraphTie& tie) const;
  FourDofError::Measurement Measurement(const PoseGraphLoop& loop) const;
  Eigen::Matrix4d LoopSqrtInformation(const PoseGraphLoop& loop) const;
  Eigen::Matrix4d OdometryInformation(double distance) const;
  /// Adds what a tie knows to what its nodes know of each other.
  void AddTie(const PoseGraphTie& tie);
  void RemoveTie(int a, int b);
  /// Over a way of that length [m].
  void AddOdometry(int from, int to, double distance);
  void RehangOnOwn(int sequence);
  void Reconnect();
  void Regroup();
  /// Turns and then shifts a group of sequences.
  void MoveGroup(int group, double yaw, const Eigen::Vector3d& t);
  void JoinGroups(const PoseGraphLoop& loop);
  int Group(int sequence) const;
  bool IsConstant(int node) const;
  std::vector<int> Scope(std::size_t most) const;
  void AddEdges(const std::vector<int>& scope, PoseGraphProblem* problem) const;
  /// Of the robust kernel at the present state.
  double KernelWeight(const PoseGraphLoop& loop) const;
  /// Turns a loop into a tie.
  void Absorb(int id);
  void SettleLoops(const std::vector<int>& ids, Settled* settled);
  std::set<int> Around(int node) const;
  void DropAll(const std::vector<int>& nodes);
  void DropSegment(const std::vector<int>& dropped);
  static Hook MakeHook(const PoseGraphNode& hung, int holder, const PoseGraphNode& stays);
  /// Hangs a node where it is on the nearest two of the given ones.
  void SetHooks(int node, std::vector<int> holders);
  /// Drops a node that nothing is tied to any more.
  void Hang(int node, std::vector<int> holders);

  PoseGraphOptions options_;
  std::deque<Keyframe> keyframes_;
  std::vector<Slot> slots_;
  std::vector<int> free_slots_;
  std::vector<int> live_;       ///< nodes that have slots, in order
  std::deque<int> window_;      ///< those of them that are dropped one day
  std::vector<int> group_;      ///< per sequence: the lowest sequence it is joined to
  std::vector<int> first_;      ///< per sequence: its first node
  std::vector<int> map_group_;  ///< per sequence of FromParts: group_, as it was then
  std::map<int, PoseGraphLoop> loops_;
  int next_loop_ = 0;
  std::map<std::pair<int, int>, PoseGraphTie> ties_;
};

}  // namespace deja_view
