#pragma once

#include <chrono>

namespace deja_view {

/// Wall time from lap to lap.
class Stopwatch {
 public:
  double LapMs() {
    const auto now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace deja_view
