#include "solve_schedule.hpp"

#include <utility>

namespace deja_view {

SolveSchedule::SolveSchedule(const SolveOptions& options, SolveExecutor executor)
    : options_(options), executor_(std::move(executor)) {}

SolveSchedule::~SolveSchedule() {
  if (pending_ && pending_->done.valid()) {
    pending_->done.wait();
  }
}

void SolveSchedule::NoteLoop(const PoseGraphLoop& loop, bool joins, const PoseGraph& graph) {
  ++loops_;
  is_surprised_ =
      is_surprised_ || joins || graph.SquaredError(loop) > options_.surprise * options_.surprise;
}

void SolveSchedule::StartIfDue(const PoseGraph& graph) {
  const int window = graph.options().window;
  const bool is_waited_for =
      window > 0 && static_cast<int>(graph.window_size()) > window + window / 4;
  if (pending_ || loops_ == 0 ||
      !(is_surprised_ || is_waited_for || loops_ >= options_.every_loops)) {
    return;
  }
  Pending solve;
  solve.problem = std::make_shared<PoseGraphProblem>(
      is_surprised_ ? graph.Problem()
                    : graph.Problem(static_cast<std::size_t>(options_.most_nodes)));
  solve.due = graph.size() + options_.latency - 1 +
              static_cast<int>(solve.problem->nodes.size()) / options_.nodes_per_latency;
  if (executor_) {
    solve.done = executor_([problem = solve.problem] { problem->Solve(); });
  } else {
    solve.problem->Solve();
  }
  pending_ = std::move(solve);
  Reset();
}

bool SolveSchedule::TakeIfDue(PoseGraph* graph) {
  if (!pending_ || graph->size() <= pending_->due) {
    return false;
  }
  Finish(graph);
  return true;
}

void SolveSchedule::Finish(PoseGraph* graph) {
  if (!pending_) {
    return;
  }
  if (pending_->done.valid()) {
    pending_->done.get();
  }
  graph->TakeSolution(*pending_->problem);
  pending_.reset();
}

void SolveSchedule::Restart() {
  if (pending_ && pending_->done.valid()) {
    pending_->done.get();
  }
  pending_.reset();
  ++loops_;
  is_surprised_ = true;
}

void SolveSchedule::Reset() {
  loops_ = 0;
  is_surprised_ = false;
}

}  // namespace deja_view
