#pragma once

#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include <future>
#include <memory>
#include <optional>

namespace deja_view {

/// Decides when the pose graph is solved, apart from it and perhaps elsewhere, and when the
/// solution is taken over: after a number of keyframes that does not depend on how long the solver
/// took, so that every run gives the same. The whole graph is solved when a loop was a surprise,
/// else the nodes about the newest ones.
class SolveSchedule {
 public:
  /// An empty `executor` solves in the caller's thread.
  SolveSchedule(const SolveOptions& options, SolveExecutor executor);
  ~SolveSchedule();
  SolveSchedule(const SolveSchedule&) = delete;
  SolveSchedule& operator=(const SolveSchedule&) = delete;

  /// A loop came into the graph; `joins`: it tied two worlds together.
  void NoteLoop(const PoseGraphLoop& loop, bool joins, const PoseGraph& graph);

  /// Starts solving when enough loops came, one of them was a surprise, or nodes wait to be
  /// dropped, unless a solution is under way.
  void StartIfDue(const PoseGraph& graph);

  /// Takes the solution over when it is due; true when it did.
  bool TakeIfDue(PoseGraph* graph);

  /// Waits for a solution under way and takes it over.
  void Finish(PoseGraph* graph);

  /// The graph came apart: a solution under way is void, and the whole graph is to be solved.
  void Restart();

  /// Nothing is left to solve: the graph has just been solved, or is another one.
  void Reset();

  /// A solution is under way.
  bool is_pending() const { return pending_.has_value(); }
  /// Loops came since the last solve began.
  bool has_news() const { return loops_ > 0; }

 private:
  struct Pending {
    std::shared_ptr<PoseGraphProblem> problem;
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
