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
  if (pending_ || !(is_surprised_ || loops_ >= options_.every_loops)) {
    return;
  }
  Pending solve;
  solve.snapshot = std::make_shared<PoseGraph>(graph);
  solve.due = graph.size() + options_.latency - 1 + graph.size() / options_.nodes_per_latency;
  if (executor_) {
    solve.done = executor_([snapshot = solve.snapshot] { snapshot->Solve(); });
  } else {
    solve.snapshot->Solve();
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
  graph->TakeSolution(*pending_->snapshot);
  pending_.reset();
}

void SolveSchedule::Reset() {
  loops_ = 0;
  is_surprised_ = false;
}

}  // namespace deja_view
