#include "loop_measurements.hpp"

#include "deja_view/base/check.hpp"

#include <limits>

namespace deja_view {

void LoopMeasurements::Add(const LoopMeasurement& measurement, int newest) {
  DEJA_VIEW_CHECK_OP(measurement.current, <=, newest);
  const int passed = (newest - measurement.current) / latency_;
  waiting_.emplace(measurement.current + (passed + 1) * latency_, measurement);
}

std::vector<LoopMeasurement> LoopMeasurements::TakeDue(int newest) {
  std::vector<LoopMeasurement> due;
  const auto end = waiting_.upper_bound(newest);
  for (auto it = waiting_.begin(); it != end; ++it) {
    due.push_back(it->second);
  }
  waiting_.erase(waiting_.begin(), end);
  return due;
}

std::vector<LoopMeasurement> LoopMeasurements::TakeAll() {
  return TakeDue(std::numeric_limits<int>::max());
}

}  // namespace deja_view
