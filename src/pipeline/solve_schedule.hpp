#pragma once

#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <future>
#include <memory>
#include <optional>

namespace deja_view {

/// Decides when the pose graph is solved, on a snapshot and perhaps elsewhere, and when the
/// solution is taken over: after a number of keyframes that does not depend on how long the solver
/// took, so that every run gives the same.
class SolveSchedule {
 public:
  /// An empty `executor` solves in the caller's thread.
  SolveSchedule(const SolveOptions& options, SolveExecutor executor);
  ~SolveSchedule();
  SolveSchedule(const SolveSchedule&) = delete;
  SolveSchedule& operator=(const SolveSchedule&) = delete;

  /// A loop came into the graph; `joins`: it tied two worlds together.
  void NoteLoop(const PoseGraphLoop& loop, bool joins, const PoseGraph& graph);

  /// Starts solving a snapshot when enough loops came or one of them was a surprise, unless a
  /// solution is under way.
  void StartIfDue(const PoseGraph& graph);

  /// Takes the solution over when it is due; true when it did.
  bool TakeIfDue(PoseGraph* graph);

  /// Waits for a solution under way and takes it over.
  void Finish(PoseGraph* graph);

  /// Nothing is left to solve: the graph has just been solved, or is another one.
  void Reset();

 private:
  struct Pending {
    std::shared_ptr<PoseGraph> snapshot;
    std::future<void> done;  ///< invalid when solved already
    int due = 0;             ///< size of the graph beyond which the solution is taken over
  };

  SolveOptions options_;
  SolveExecutor executor_;
  std::optional<Pending> pending_;
  int loops_ = 0;  ///< since the last solve
  bool is_surprised_ = false;
};

}  // namespace deja_view
