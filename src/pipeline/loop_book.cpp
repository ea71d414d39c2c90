#include "loop_book.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <tuple>
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

/// It is between two sequences.
bool Crosses(const LoopReport& loop, const PoseGraph& graph) {
  return graph.node(loop.old).sequence != graph.node(loop.current).sequence;
}

}  // namespace

LoopBook::LoopBook(const LoopConsistencyOptions& options, const std::vector<LoopReport>& of_map)
    : consistency_(options) {
  for (const LoopReport& report : of_map) {
    records_[next_++] = {report, State::kAccepted, -1, true};
  }
}

LoopBook::Entry LoopBook::Enter(LoopReport loop, PoseGraph* graph) {
  PoseGraphLoop edge;
  edge.from = loop.old;
  edge.to = loop.current;
  edge.T_from_to = loop.T_Bold_Bcurrent;
  edge.covariance = loop.covariance;
  edge.scene_depth = loop.scene_depth;
  const bool was_joined =
      graph->AreJoined(graph->node(edge.from).sequence, graph->node(edge.to).sequence);
  const int number = next_++;
  LoopConsistency::Decision decision = consistency_.Add(edge, number, *graph);
  Entry entry;
  entry.separates = decision.contradicts_join;
  if (entry.separates) {
    entry.withdrawn = Separate(graph->node(edge.to).sequence, graph);
    decision = consistency_.Reconsider(*graph);
  }
  loop.reason = ReasonOf(decision.state);
  LoopRecord& entered = records_[number];
  entered.report = std::move(loop);
  entered.state = decision.state;
  entry.reason = entered.report.reason;
  for (const LoopConsistency::Entry& believed : decision.believed) {
    LoopRecord& record = records_.at(believed.tag);
    record.state = State::kAccepted;
    record.report.reason = RejectReason::kNone;
    const int id = graph->AddLoop(believed.loop);
    ++believed_[record.report.old];
    record.edge = graph->loops().count(id) > 0 ? id : -1;
    if (record.edge < 0 && Crosses(record.report, *graph)) {
      settled_.emplace_back(record.report.old, record.report.current);
    }
    entry.believed.push_back(believed.tag);
  }
  entry.joins = (!was_joined || entry.separates) && !entry.believed.empty();
  ForgetOldest();
  return entry;
}

// Called with each record that comes, so that one at most is forgotten by the consistency check.
void LoopBook::ForgetOldest() {
  const auto it = records_.find(next_ - consistency_.memory() - 1);
  if (it != records_.end() && it->second.edge < 0 && !it->second.is_of_map) {
    records_.erase(it);
  }
}

int LoopBook::FindRefinable(const LoopMeasurement& measurement, const PoseGraph& graph) const {
  constexpr double kMaxChange = 0.5;  // [m], [rad]: near the loop's or it is wrong
  const auto it = std::find_if(records_.rbegin(), records_.rend(), [&](const auto& entry) {
    const LoopRecord& record = entry.second;
    return record.edge >= 0 && record.report.old == measurement.old &&
           record.report.current == measurement.current;
  });
  if (it == records_.rend() || !measurement.T_Bold_Bcurrent.IsFinite()) {
    return -1;
  }
  const LoopRecord& record = it->second;
  const Rigid3 change = record.report.T_Bold_Bcurrent.Inverse() * measurement.T_Bold_Bcurrent;
  const PoseGraphLoop& edge = graph.loop(record.edge);
  const bool is_near = change.t.norm() <= kMaxChange && RotationAngle(change.q) <= kMaxChange;
  const bool is_its_own = edge.from == measurement.old && edge.to == measurement.current;
  return is_near && is_its_own ? it->first : -1;
}

bool LoopBook::CanRefine(const LoopMeasurement& measurement, const PoseGraph& graph) const {
  return FindRefinable(measurement, graph) >= 0;
}

bool LoopBook::Refine(const LoopMeasurement& measurement, PoseGraph* graph) {
  const int number = FindRefinable(measurement, *graph);
  if (number < 0) {
    return false;
  }
  LoopRecord& record = records_.at(number);
  record.report.T_Bold_Bcurrent = measurement.T_Bold_Bcurrent;
  graph->UpdateLoop(record.edge, measurement.T_Bold_Bcurrent);
  return true;
}

std::map<int, LoopRecord>::iterator LoopBook::Find(int edge) {
  return std::find_if(records_.begin(), records_.end(), [edge](const auto& entry) {
    return entry.second.edge == edge;
  });
}

// Also of those of which the graph has nothing left but ties.
std::vector<LoopReport> LoopBook::Separate(int sequence, PoseGraph* graph) {
  const auto crosses = [&](int a, int b) {
    return (graph->node(a).sequence == sequence) != (graph->node(b).sequence == sequence);
  };
  std::vector<int> edges = graph->Separate(sequence);
  for (const auto& [number, record] : records_) {
    // Of a dropped keyframe that hung on the other sequence, its loop was within that.
    if (record.edge >= 0 && crosses(record.report.old, record.report.current) &&
        graph->loops().count(record.edge) > 0) {
      graph->RemoveLoop(record.edge);
      edges.push_back(record.edge);
    }
  }
  std::vector<LoopReport> withdrawn = Withdraw(edges, *graph);
  const auto is_gone = [&](const std::pair<int, int>& loop) {
    return crosses(loop.first, loop.second);
  };
  for (const auto& loop : settled_) {
    if (is_gone(loop)) {
      LoopReport report;
      std::tie(report.old, report.current) = loop;
      report.reason = RejectReason::kWithdrawn;
      withdrawn.push_back(report);
      --believed_[report.old];
    }
  }
  settled_.erase(std::remove_if(settled_.begin(), settled_.end(), is_gone), settled_.end());
  consistency_.Separate(sequence, *graph);
  return withdrawn;
}

std::vector<LoopReport> LoopBook::Withdraw(const std::vector<int>& edges, const PoseGraph& graph) {
  std::vector<LoopReport> reports;
  for (const int edge : edges) {
    const auto it = Find(edge);
    DEJA_VIEW_CHECK(it != records_.end());
    reports.push_back(it->second.report);
    --believed_[it->second.report.old];
    reports.back().reason = RejectReason::kWithdrawn;
    consistency_.Withdraw(it->first, it->second.report.old, it->second.report.current, graph);
    records_.erase(it);
  }
  return reports;
}

void LoopBook::Settle(const std::vector<int>& edges, const PoseGraph& graph) {
  for (const int edge : edges) {
    const auto it = Find(edge);
    DEJA_VIEW_CHECK(it != records_.end());
    it->second.edge = -1;
    const LoopReport& report = it->second.report;
    if (Crosses(report, graph)) {
      settled_.emplace_back(report.old, report.current);
    }
    if (!IsRemembered(it->first)) {
      records_.erase(it);
    }
  }
}

int LoopBook::CountOf(int place) const {
  const auto it = believed_.find(place);
  return it == believed_.end() ? 0 : it->second;
}

int LoopBook::NewestLocalised() const {
  int newest = -1;
  for (const auto& [number, record] : records_) {
    newest = record.edge >= 0 ? std::max(newest, record.report.current) : newest;
  }
  return newest;
}

std::vector<LoopReport> LoopBook::Accepted() const {
  std::vector<const LoopRecord*> accepted;
  for (const auto& [number, record] : records_) {
    if (record.edge >= 0 || record.is_of_map) {
      accepted.push_back(&record);
    }
  }
  std::stable_sort(accepted.begin(), accepted.end(), [](const LoopRecord* a, const LoopRecord* b) {
    return a->edge < b->edge;
  });
  std::vector<LoopReport> reports;
  reports.reserve(accepted.size());
  for (const LoopRecord* record : accepted) {
    reports.push_back(record->report);
  }
  return reports;
}

}  // namespace deja_view
