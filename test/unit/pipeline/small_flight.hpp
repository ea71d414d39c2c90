#pragma once

#include "deja_view/lab/sim/simulator.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace deja_view::test {

/// Two rounds or so through a small hall, with an odometry that drifts three per cent. `session` 2
/// is another flight through the same hall.
inline sim::SimOptions SmallFlightOptions(std::uint64_t session) {
  sim::SimOptions options = sim::MakePreset("small");
  options.flight_seed = session;
  options.start_stamp_ns += static_cast<std::int64_t>(session) * 1'000'000'000'000;
  options.flight.duration_s = 30.0;
  options.sensor.image_rate_hz = 2.0;
  options.sensor.samples = 1;
  options.imu.rate_hz = 20.0;
  options.world.light_spacing_m = 0.5;
  options.vio.drift_min = options.vio.drift_max = 0.03;
  options.threads = 1;
  return options;
}

inline const sim::RecordedFlight& SmallFlight(std::uint64_t session) {
  static const auto world = std::make_shared<const sim::World>(1, SmallFlightOptions(1).world, 1);
  static const sim::RecordedFlight flights[] = {
      sim::Record(sim::Simulator(SmallFlightOptions(1), world)),
      sim::Record(sim::Simulator(SmallFlightOptions(2), world))};
  return flights[session - 1];
}

/// Loop closing for so short a flight: loops to what is a few seconds old, solved often, every
/// keyframe a place.
inline LoopCloserOptions FlightOptions() {
  LoopCloserOptions options;
  options.candidates.min_age_s = 6.0;
  options.solve.every_loops = 5;
  options.map_spacing_m = 0;
  return options;
}

inline std::shared_ptr<const Vocabulary> FlightVocabulary() {
  static const auto vocabulary = Vocabulary::Open(DEJA_VIEW_VOCABULARY);
  return vocabulary;
}

inline LoopCloser MakeCloser(std::uint64_t session,
                             const LoopCloserOptions& options = FlightOptions()) {
  const sim::RecordedFlight& flight = SmallFlight(session);
  return {options, flight.camera, flight.T_B_C, FlightVocabulary()};
}

/// What came of a flight.
struct Outcome {
  std::vector<KeyframeReport> reports;
  std::vector<KeyframeInfo> keyframes;
  std::vector<LoopReport> loops;
  std::vector<LoopReport> withdrawn;  ///< at the end
  int places = 0;
};

/// The first session, whole.
inline Outcome Fly(const LoopCloserOptions& options, SolveExecutor executor = {}) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloser closer(options, flight.camera, flight.T_B_C, FlightVocabulary(), std::move(executor));
  Outcome outcome;
  for (const KeyframeInput& keyframe : flight.keyframes) {
    outcome.reports.push_back(closer.AddKeyframe(keyframe));
  }
  outcome.withdrawn = closer.OptimizeFully();
  for (int i = 0; i < closer.keyframe_count(); ++i) {
    outcome.keyframes.push_back(closer.keyframe(i));
  }
  outcome.loops = closer.accepted_loops();
  outcome.places = closer.place_count();
  return outcome;
}

inline const Outcome& DefaultOutcome() {
  static const Outcome outcome = Fly(FlightOptions());
  return outcome;
}

}  // namespace deja_view::test
