#pragma once

#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/pose_graph/loop_consistency.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <map>
#include <utility>
#include <vector>

#include "loop_measurements.hpp"

namespace deja_view {

/// A loop that passed verification, and what has become of it. Its number in the book is its
/// identity.
struct LoopRecord {
  LoopReport report;
  LoopConsistency::State state = LoopConsistency::State::kPending;
  int edge = -1;           ///< id among the pose graph's loops; -1: it is none
  bool is_of_map = false;  ///< of a loaded map
};

/// The verified loops that are still of use: those that wait for others to agree with them, and
/// those in the graph.
class LoopBook {
 public:
  explicit LoopBook(const LoopConsistencyOptions& options) : consistency_(options) {}
  /// Begins with the loops of a loaded map.
  LoopBook(const LoopConsistencyOptions& options, const std::vector<LoopReport>& of_map);

  /// What one more loop led to.
  struct Entry {
    RejectReason reason = RejectReason::kInconsistent;  ///< kNone: it is in the graph now
    std::vector<int> believed;  ///< records that came into the graph, the new one last if it did
    bool joins = false;         ///< the first of them tied two worlds together
    bool separates = false;     ///< before that it took back that the worlds were joined otherwise
    std::vector<LoopReport> withdrawn;  ///< then: those that had joined them
  };
  /// Enters a verified loop between two nodes of `graph` and adds to the graph what is believed
  /// from now on.
  Entry Enter(LoopReport loop, PoseGraph* graph);

  /// There is such a loop in the graph, and its measurement is near the new one.
  bool CanRefine(const LoopMeasurement& measurement, const PoseGraph& graph) const;
  /// Replaces an accepted loop's measurement by a better one of the same; false, and no change,
  /// when it can't be refined so.
  bool Refine(const LoopMeasurement& measurement, PoseGraph* graph);

  /// The graph has no such loops any more; returns their reports, as withdrawn.
  std::vector<LoopReport> Withdraw(const std::vector<int>& edges, const PoseGraph& graph);
  /// The graph has made them part of itself: nothing more will become of them.
  void Settle(const std::vector<int>& edges, const PoseGraph& graph);

  const LoopRecord& operator[](int i) const { return records_.at(i); }
  int size() const { return next_; }  ///< records ever
  /// Loops with a place that were believed, except those withdrawn.
  int CountOf(int place) const;
  /// Records that are kept.
  std::size_t kept() const { return records_.size(); }
  /// Newest keyframe that has a loop in the graph; -1: none has.
  int NewestLocalised() const;

  /// A loaded map's loops, and then those of the graph in its order.
  std::vector<LoopReport> Accepted() const;

 private:
  std::map<int, LoopRecord>::iterator Find(int edge);
  /// Takes back that the sequence is joined to others.
  std::vector<LoopReport> Separate(int sequence, PoseGraph* graph);
  /// -1: there is none that can be refined so.
  int FindRefinable(const LoopMeasurement& measurement, const PoseGraph& graph) const;
  bool IsRemembered(int record) const { return record >= next_ - consistency_.memory(); }
  void ForgetOldest();

  LoopConsistency consistency_;
  std::map<int, LoopRecord> records_;
  std::map<int, int> believed_;  ///< loops per place
  /// Old and current keyframe of those loops between sequences that the graph has made part of
  /// itself.
  std::vector<std::pair<int, int>> settled_;
  int next_ = 0;
};

}  // namespace deja_view
