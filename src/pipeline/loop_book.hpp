#pragma once

#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/pose_graph/loop_consistency.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <vector>

namespace deja_view {

/// A loop that passed verification, and what has become of it. Its index in the book is its
/// identity.
struct LoopRecord {
  LoopReport report;
  LoopConsistency::State state = LoopConsistency::State::kPending;
  int edge = -1;  ///< index among the pose graph's loops; -1 while it is not believed
};

/// All verified loops: those that wait for others to agree with them, and those in the graph.
class LoopBook {
 public:
  explicit LoopBook(const LoopConsistencyOptions& options) : consistency_(options) {}
  /// Begins with the loops that are in a graph already, in its order.
  LoopBook(const LoopConsistencyOptions& options, const std::vector<LoopReport>& in_graph);

  /// What one more loop led to.
  struct Entry {
    RejectReason reason = RejectReason::kInconsistent;  ///< kNone: it is in the graph now
    std::vector<int> believed;  ///< records that came into the graph, the new one last if it did
    bool joins = false;         ///< the first of them tied two worlds together
  };
  /// Enters a verified loop between two nodes of `graph` and adds to the graph what is believed
  /// from now on.
  Entry Enter(LoopReport loop, PoseGraph* graph);

  /// Replaces an accepted loop's measurement by a better one of the same; false, and no change,
  /// when there is no such loop or the two are far apart.
  bool Refine(int old, int current, const Rigid3& T_Bold_Bcurrent, PoseGraph* graph);

  const LoopRecord& operator[](int i) const { return records_.at(static_cast<std::size_t>(i)); }
  int size() const { return static_cast<int>(records_.size()); }

  /// The loops of the graph, in its order.
  std::vector<LoopReport> Accepted() const;

 private:
  LoopConsistency consistency_;
  std::vector<LoopRecord> records_;
};

}  // namespace deja_view
