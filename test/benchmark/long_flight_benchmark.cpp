// A hall of which 40 s are flown back and forth, with an odometry that drifts as it goes: what a
// keyframe costs when the place is known for long. One iteration is one flight; the time is that of
// all keyframes. Counters: of the graph's part the mean and the largest wall time [ms], of whole
// keyframes mean and largest CPU time [ms], resident memory at the end without the recorded images
// [MB], places, loops, candidates verified per keyframe, the part of the keyframes with a loop, and
// the error of the trajectory at the end (APE, RMSE [mm], also of the odometry's). The mean wall
// time of each step [ms] is that of the last quarter of the flight.
#include "deja_view/base/angles.hpp"
#include "deja_view/lab/evaluation/ape.hpp"
#include "deja_view/lab/sim/simulator.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "resident_memory.hpp"
#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

constexpr double kMegabyte = 1024.0 * 1024.0;

double ThreadCpuMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

const sim::RecordedFlight& Hall() {
  static const sim::RecordedFlight flight = [] {
    sim::SimOptions options = sim::MakePreset("hall");
    options.flight.duration_s = 40;
    options.imu.rate_hz = 20;
    return sim::Record(sim::Simulator(options));
  }();
  return flight;
}

/// Flies the recorded keyframes forth and back, and forth again.
class BackAndForth {
 public:
  explicit BackAndForth(const sim::RecordedFlight& flight) : flight_(flight) {}

  KeyframeInput Next() {
    const auto count = static_cast<int>(flight_.keyframes.size());
    const int leg = flown_ / (count - 1);
    const int step = flown_ % (count - 1);
    const int i = leg % 2 == 0 ? step : count - 1 - step;
    const Rigid3& T = flight_.T_W_B[static_cast<std::size_t>(i)];
    Drift(T.t);
    truth_.push_back(T.t);
    return Seen(flight_.keyframes[static_cast<std::size_t>(i)], T, leg);
  }

  const std::vector<Eigen::Vector3d>& truth() const { return truth_; }

 private:
  /// Turns and shifts the odometry's world about where the drone is.
  void Drift(const Eigen::Vector3d& to) {
    const Eigen::Vector3d from = truth_.empty() ? to : truth_.back();
    const double root = std::sqrt((to - from).norm());
    const Eigen::Vector3d from_drifted = drift_ * from;
    drift_.q = FromYaw(Yaw(drift_.q) + 0.1 * kDegree * root * normal_(rng_));
    drift_.t = from_drifted - drift_.q * from +
               0.01 * root * Eigen::Vector3d(normal_(rng_), normal_(rng_), normal_(rng_));
  }

  /// The keyframe as the drifting odometry hands it over, a quarter of a second after the last.
  KeyframeInput Seen(const KeyframeInput& recorded, const Rigid3& T_W_B, int leg) {
    constexpr std::int64_t kStepNs = 250'000'000;
    KeyframeInput seen = recorded;
    seen.stamp_ns = 1'600'000'000'000'000'000 + kStepNs * flown_++;
    seen.T_W_B = drift_ * T_W_B;
    seen.starts_sequence = false;
    const Rigid3 T_seen_recorded = seen.T_W_B * recorded.T_W_B.Inverse();
    for (TrackedPoint& point : seen.points) {
      point.p_W = T_seen_recorded * point.p_W;
      point.feature_id += std::int64_t{1'000'000} * leg;
    }
    seen.image = cv::Mat();  // not into the recorded one, which would get noisier with every pass
    cv::add(recorded.image, Noise(flown_ % kNoises), seen.image, cv::noArray(), CV_8U);
    return seen;
  }

  /// Of a camera, 2 grey levels; another one in each pass over a keyframe.
  static const cv::Mat& Noise(int i) {
    static const std::vector<cv::Mat> noises = [] {
      std::vector<cv::Mat> made;
      cv::RNG rng(1);
      for (int k = 0; k < kNoises; ++k) {
        made.emplace_back(Hall().keyframes.front().image.size(), CV_8SC1);
        rng.fill(made.back(), cv::RNG::NORMAL, 0.0, 2.0);
      }
      return made;
    }();
    return noises[static_cast<std::size_t>(i)];
  }

  static constexpr int kNoises = 31;

  const sim::RecordedFlight& flight_;
  std::vector<Eigen::Vector3d> truth_;
  Rigid3 drift_;
  std::mt19937 rng_{1};
  std::normal_distribution<double> normal_;
  int flown_ = 0;
};

/// Times of many keyframes [ms].
struct Times {
  double sum = 0, largest = 0;
  void Add(double ms) {
    sum += ms;
    largest = std::max(largest, ms);
  }
};

double ImagesMb(const sim::RecordedFlight& flight) {
  const cv::Mat& image = flight.keyframes.front().image;
  return static_cast<double>(flight.keyframes.size() * image.total()) / kMegabyte;
}

void BM_BackAndForth(benchmark::State& state) {
  const sim::RecordedFlight& hall = Hall();
  const auto vocabulary = Vocabulary::Open(DEJA_VIEW_VOCABULARY);
  const auto keyframes = static_cast<int>(state.range(0));
  for (auto _ : state) {
    LoopCloser closer({}, hall.camera, hall.T_B_C, vocabulary);
    BackAndForth flight(hall);
    Times graph;
    Times cpu;
    int loops = 0;
    int localised = 0;
    std::size_t verified = 0;
    KeyframeTimes late;
    for (int i = 0; i < keyframes; ++i) {
      const KeyframeInput input = flight.Next();
      const double before_ms = ThreadCpuMs();
      const KeyframeReport report = closer.AddKeyframe(input);
      cpu.Add(ThreadCpuMs() - before_ms);
      graph.Add(report.times.graph);
      verified += report.loops.size();
      if (i >= keyframes - keyframes / 4) {
        late.features += report.times.features;
        late.words += report.times.words;
        late.query += report.times.query;
        late.verification += report.times.verification;
      }
      localised += report.reason == RejectReason::kNone ? 1 : 0;
      loops += static_cast<int>(std::count_if(report.loops.begin(),
                                              report.loops.end(),
                                              [](const auto& loop) { return loop.accepted(); }));
    }
    state.counters["rss_mb"] = test::ResidentKb() / 1024.0 - ImagesMb(hall);
    closer.OptimizeFully();
    std::vector<Eigen::Vector3d> corrected;
    std::vector<Eigen::Vector3d> vio;
    for (int i = 0; i < keyframes; ++i) {
      corrected.push_back(closer.keyframe(i).T_M_B.t);
      vio.push_back(closer.keyframe(i).T_W_B.t);
    }
    state.counters["vio_ape_mm"] = 1000 * ComputeApe(flight.truth(), vio).rmse;
    state.counters["graph_ms"] = graph.sum / keyframes;
    state.counters["graph_worst_ms"] = graph.largest;
    state.counters["cpu_ms"] = cpu.sum / keyframes;
    state.counters["cpu_worst_ms"] = cpu.largest;
    const int last_quarter = keyframes / 4;
    state.counters["features_ms"] = late.features / last_quarter;
    state.counters["words_ms"] = late.words / last_quarter;
    state.counters["query_ms"] = late.query / last_quarter;
    state.counters["verification_ms"] = late.verification / last_quarter;
    state.counters["verified"] = static_cast<double>(verified) / keyframes;
    state.counters["places"] = closer.place_count();
    state.counters["sequences"] = closer.sequence_count();
    state.counters["loops"] = loops;
    state.counters["with_loop"] = static_cast<double>(localised) / keyframes;
    state.counters["ape_mm"] = 1000 * ComputeApe(flight.truth(), corrected).rmse;
  }
}
BENCHMARK(BM_BackAndForth)
    ->Arg(1053)
    ->Arg(5265)
    ->Arg(50000)
    ->Iterations(1)
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace deja_view
