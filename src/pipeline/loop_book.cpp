#include "loop_book.hpp"

#include <algorithm>
#include <utility>

namespace deja_view {
namespace {

using State = LoopConsistency::State;

RejectReason ReasonOf(State state) {
  switch (state) {
    case State::kAccepted:
      return RejectReason::kNone;
    case State::kImplausible:
      return RejectReason::kImplausible;
    case State::kPending:
      break;
  }
  return RejectReason::kInconsistent;
}

}  // namespace

LoopBook::LoopBook(const LoopConsistencyOptions& options, const std::vector<LoopReport>& in_graph)
    : consistency_(options) {
  for (const LoopReport& report : in_graph) {
    records_.push_back({report, State::kAccepted, size()});
  }
}

LoopBook::Entry LoopBook::Enter(LoopReport loop, PoseGraph* graph) {
  PoseGraphLoop edge;
  edge.from = loop.old;
  edge.to = loop.current;
  edge.T_from_to = loop.T_Bold_Bcurrent;
  edge.covariance = loop.covariance;
  edge.scene_depth = loop.scene_depth;
  const auto sequence = [&](int node) {
    return graph->nodes().at(static_cast<std::size_t>(node)).sequence;
  };
  const bool was_joined = graph->AreJoined(sequence(edge.from), sequence(edge.to));
  const LoopConsistency::Decision decision = consistency_.Add(edge, size(), *graph);
  loop.reason = ReasonOf(decision.state);
  records_.push_back({std::move(loop), decision.state, -1});
  Entry entry;
  entry.reason = records_.back().report.reason;
  for (const LoopConsistency::Entry& believed : decision.believed) {
    LoopRecord& record = records_.at(static_cast<std::size_t>(believed.tag));
    record.state = State::kAccepted;
    record.report.reason = RejectReason::kNone;
    record.edge = static_cast<int>(graph->loops().size());
    graph->AddLoop(believed.loop);
    entry.believed.push_back(believed.tag);
  }
  entry.joins = !was_joined && !entry.believed.empty();
  return entry;
}

bool LoopBook::Refine(int old, int current, const Rigid3& T_Bold_Bcurrent, PoseGraph* graph) {
  constexpr double kMaxChange = 0.5;  // [m], [rad]: near the loop's or it is wrong
  const auto it = std::find_if(records_.rbegin(), records_.rend(), [&](const LoopRecord& record) {
    return record.edge >= 0 && record.report.old == old && record.report.current == current;
  });
  if (it == records_.rend() || !T_Bold_Bcurrent.IsFinite()) {
    return false;
  }
  const Rigid3 change = it->report.T_Bold_Bcurrent.Inverse() * T_Bold_Bcurrent;
  if (change.t.norm() > kMaxChange || RotationAngle(change.q) > kMaxChange) {
    return false;
  }
  it->report.T_Bold_Bcurrent = T_Bold_Bcurrent;
  return graph->UpdateLoop(old, current, T_Bold_Bcurrent);
}

std::vector<LoopReport> LoopBook::Accepted() const {
  std::vector<const LoopRecord*> in_graph;
  for (const LoopRecord& record : records_) {
    if (record.edge >= 0) {
      in_graph.push_back(&record);
    }
  }
  std::sort(in_graph.begin(), in_graph.end(), [](const LoopRecord* a, const LoopRecord* b) {
    return a->edge < b->edge;
  });
  std::vector<LoopReport> reports;
  reports.reserve(in_graph.size());
  for (const LoopRecord* record : in_graph) {
    reports.push_back(record->report);
  }
  return reports;
}

}  // namespace deja_view
