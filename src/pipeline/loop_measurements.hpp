#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <map>
#include <vector>

namespace deja_view {

/// The VIO's own measurement of a loop between two keyframes.
struct LoopMeasurement {
  int old = -1;
  int current = -1;
  Rigid3 T_Bold_Bcurrent;  ///< [m]
};

/// Measurements on their way into the graph.
///
/// A VIO answers when it has the time: a millisecond decides between which two keyframes its answer
/// comes, and no recording tells that. So answers wait for the keyframe that comes `latency`
/// keyframes after the loop's own, or twice as many, and so on: the first that has not passed yet.
class LoopMeasurements {
 public:
  /// `latency`: keyframes, at least 1.
  explicit LoopMeasurements(int latency) : latency_(latency) {}

  /// `newest`: the newest keyframe when it comes, `measurement.current` or a later one.
  void Add(const LoopMeasurement& measurement, int newest);

  /// Those that are used with this keyframe.
  std::vector<LoopMeasurement> TakeDue(int newest);
  std::vector<LoopMeasurement> TakeAll();

 private:
  int latency_;
  std::multimap<int, LoopMeasurement> waiting_;  ///< by the keyframe that they wait for
};

}  // namespace deja_view
