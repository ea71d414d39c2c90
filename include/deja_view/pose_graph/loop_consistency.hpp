#pragma once

#include "deja_view/pose_graph/pose_graph.hpp"

#include <algorithm>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace deja_view {

/// Lengths named "_over_depth" are in units of the scene's depth, as the loops measure it: what is
/// a short way in a hall leads through a whole room.
struct LoopConsistencyOptions {
  int min_support = 2;  ///< other loops that must agree before one is believed
  int min_support_join =
      4;  ///< the same for the loops that join two worlds, where nothing else can object
  double max_support_ratio = 0.34;  ///< contradicting over agreeing loops
  // Loops that join two worlds have nothing but each other: repeated structure gives many that
  // agree, but from one stretch of the flight, or with rivals.
  /// Of the flight over which they must spread, or of a map's places, `min_support_join` of them: a
  /// copy of what a drone sees stays in its view while it flies less than the scene is deep.
  double min_span_over_depth = 1.0;
  /// Loops whose both ends lie within this see the same two places: they are one witness.
  double same_place_over_depth = 0.02;
  double max_rival_ratio = 0.5;  ///< joining: rivals (believed or not) over agreeing loops
  // A rival puts the worlds elsewhere, by more than a loop that is merely imprecise: by so much
  // over the scene's depth, or turned by so much.
  double rival_over_depth = 0.15;
  double rival_yaw_deg = 10.0;
  int span_window = 300;             ///< newest verified loops that are looked at for that
  int window = 60;                   ///< newest verified loops that a new one is compared with
  double max_path_over_depth = 3.0;  ///< of odometry on either side between two compared loops
  double max_sigmas = 3.5;           ///< of the difference, per axis and yaw
  // Drift that a single loop may claim against the corrected trajectory.
  double plausible_soon_over_depth = 0.1;  ///< right after another loop
  double plausible_over_depth = 0.2;       ///< after a way as long as the scene is deep, and later
  double plausible_m_per_m = 0.03;         ///< [m] more per metre flown since the last loop
  /// Right after another loop, when a loop is more surprising than usual: its normalised innovation
  /// exceeds the root mean square of that of the newest believed loops by `max_innovation_ratio`.
  double surprising_over_depth = 0.04;
  double max_innovation_ratio = 2.0;
  double plausible_yaw_deg = 4.0;        ///< [deg] always
  double plausible_yaw_deg_per_m = 0.3;  ///< [deg] more per metre flown since the last loop

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_support", min_support);
    v("min_support_join", min_support_join);
    v("max_support_ratio", max_support_ratio);
    v("min_span_over_depth", min_span_over_depth);
    v("same_place_over_depth", same_place_over_depth);
    v("max_rival_ratio", max_rival_ratio);
    v("rival_over_depth", rival_over_depth);
    v("rival_yaw_deg", rival_yaw_deg);
    v("span_window", span_window);
    v("window", window);
    v("max_path_over_depth", max_path_over_depth);
    v("max_sigmas", max_sigmas);
    v("plausible_soon_over_depth", plausible_soon_over_depth);
    v("plausible_over_depth", plausible_over_depth);
    v("plausible_m_per_m", plausible_m_per_m);
    v("surprising_over_depth", surprising_over_depth);
    v("max_innovation_ratio", max_innovation_ratio);
    v("plausible_yaw_deg", plausible_yaw_deg);
    v("plausible_yaw_deg_per_m", plausible_yaw_deg_per_m);
  }
  std::vector<std::string> Validate() const;
};

/// Believes a verified loop only when other loops agree with it: two loops and the odometry between
/// their ends form a cycle that must close within its noise (pairwise consistency; Mangelson et
/// al., PCM, ICRA 2018). A loop waits until enough others agree; it then enters the graph together
/// with those that waited for it. Keyframes of a loaded map are as far apart as the map says.
/// Consistent loops that claim more drift than the VIO can have gathered (a repeated structure seen
/// from frame to frame) stay out however many agree: copies of a place see it as often as it is
/// seen. What the VIO can have gathered grows with the way flown since the last loop; right after
/// one the trajectory is known about as well as the loops of late agreed with it, in units of their
/// own standard deviations, whatever the VIO and its points are worth (normalised innovation;
/// Bar-Shalom et al., Estimation with Applications to Tracking and Navigation, 2001, 5.4).
/// The first loops that join two worlds may have seen copies, too. A join falls when loops that
/// stay out would join the worlds otherwise, and show more places of the older one than all loops
/// that were believed: a copy is of some places, the truth shows all that come in view.
class LoopConsistency {
 public:
  enum class State { kPending, kImplausible, kAccepted };
  struct Entry {
    PoseGraphLoop loop;
    int tag = 0;  ///< the caller's
    State state = State::kPending;
    /// Normalised, when it was believed right after another loop; negative: not known.
    double innovation = -1;
  };

  /// What one more loop led to.
  struct Decision {
    State state = State::kPending;  ///< of the new loop
    /// Entries that are believed from now on, the new one last when it is among them.
    std::vector<Entry> believed;
    /// The two worlds of the new loop were joined wrongly: take that back (Separate), and
    /// Reconsider.
    bool contradicts_join = false;
  };

  explicit LoopConsistency(const LoopConsistencyOptions& options) : options_(options) {}

  /// Adds a verified loop and decides on it and on those that waited; `graph` holds both nodes and
  /// not yet the loop.
  Decision Add(const PoseGraphLoop& loop, int tag, const PoseGraph& graph);
  /// The graph contradicts a believed loop between nodes `from` and `to`: it speaks for no other
  /// one any more.
  void Withdraw(int tag, int from, int to, const PoseGraph& graph);
  /// No believed loop of the sequence with another one speaks for any other loop any more.
  void Separate(int sequence, const PoseGraph& graph);
  /// Decides on the newest loop again, now that `graph` has them apart.
  Decision Reconsider(const PoseGraph& graph);
  /// Newest loops that are remembered; an older one is not decided on again.
  int memory() const { return std::max(options_.window, options_.span_window); }

  /// True when the loops' cycle closes; false when it does not; `is_comparable` is false when the
  /// odometry between them is too long, or missing, to tell.
  struct Comparison {
    bool is_comparable = false;
    bool agrees = false;
    bool rivals = false;  ///< puts the worlds elsewhere
  };
  Comparison Compare(const PoseGraphLoop& a, const PoseGraphLoop& b, const PoseGraph& graph) const;

 private:
  /// What all newest loops, or those that are not believed, say about one.
  struct Evidence {
    std::vector<std::size_t> agreeing;  ///< entries of other current keyframes
    std::vector<std::size_t> rivals;    ///< entries that contradict it
    double span_m = 0;                  ///< [m] of the flight from the first to the last agreeing
  };
  Evidence Gather(const Entry& entry, const PoseGraph& graph, bool with_believed = true) const;
  /// The agreeing ones would join two worlds together with the newest loop.
  bool Suffices(const Evidence& evidence, const PoseGraph& graph) const;
  std::vector<Entry> Join(const PoseGraph& graph);
  bool ContradictsJoin(const PoseGraph& graph) const;
  /// Notes that a loop is believed.
  void Believe(Entry* entry, const PoseGraph& graph);
  /// Entries that do not see the same two places as another of them.
  int CountWitnesses(const std::vector<std::size_t>& entries, const PoseGraph& graph) const;
  /// True when the `entries` are loops with enough places of a map, far enough from each other.
  bool DoMapsPlacesSuffice(const std::vector<std::size_t>& entries, const PoseGraph& graph) const;
  std::vector<Entry> Judge(const PoseGraphLoop& loop, const PoseGraph& graph);
  /// Those of `entries` that most of the others do not contradict.
  std::vector<std::size_t> AgreeingAmongThemselves(const std::vector<std::size_t>& entries,
                                                   const PoseGraph& graph) const;
  /// `path`: see PathToHeld.
  State StateOf(const Entry& entry, double path, const PoseGraph& graph) const;
  bool IsPlausible(const PoseGraphLoop& loop, double path, const PoseGraph& graph) const;
  /// The graph has moved the trajectory to where the loop says; a first loop alone moves nothing.
  bool IsFollowed(const PoseGraphLoop& loop, const PoseGraph& graph) const;
  /// Where believed loops hold the trajectory.
  std::vector<int> HeldNodes(const PoseGraph& graph) const;
  /// Way flown [m] between a node and the nearest of `held`, or the start of its sequence.
  double PathToHeld(int node, const std::vector<int>& held, const PoseGraph& graph) const;
  /// Root mean square of the newest believed loops' normalised innovations.
  double UsualInnovation() const;
  void ForgetOldest(const PoseGraph& graph);

  LoopConsistencyOptions options_;
  std::deque<Entry> entries_;
  /// Believed loops between two sequences, by them and the place in the older one.
  std::map<std::pair<int, int>, std::map<int, int>> joining_;
  /// Per sequence: node of the newest believed and followed loop among those forgotten.
  std::map<int, int> forgotten_;
};

}  // namespace deja_view
