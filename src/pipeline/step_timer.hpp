#pragma once

#include <chrono>

namespace deja_view {

/// Adds the wall time of a scope to a step's total [ms].
class StepTimer {
 public:
  explicit StepTimer(double* total_ms) : total_ms_(total_ms) {}
  ~StepTimer() {
    *total_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }
  StepTimer(const StepTimer&) = delete;
  StepTimer& operator=(const StepTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double* total_ms_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace deja_view
