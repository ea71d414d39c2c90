// A 752 x 480 view of the default hall: radiance at 4 rays per pixel, ranges, and one step of the
// tracker.
#include "deja_view/lab/sim/image_sensor.hpp"
#include "deja_view/lab/sim/simulator.hpp"
#include "deja_view/lab/sim/vio_front_end.hpp"

#include <benchmark/benchmark.h>

namespace deja_view::sim {
namespace {

const Simulator& Hall() {
  static const Simulator simulator = [] {
    SimOptions options = MakePreset("hall");
    options.threads = 1;
    return Simulator(options);
  }();
  return simulator;
}

/// Camera pose at the n-th tenth of a second of the flight, beyond take-off.
Rigid3 CameraPose(std::size_t n) {
  return Hall().path().Pose(5.0 + 0.1 * static_cast<double>(n % 500)) * sim::SimulatedExtrinsic();
}

void BuildWorld(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(World(1, WorldOptions(), 1));
  }
}
BENCHMARK(BuildWorld)->Unit(benchmark::kMillisecond);

void RenderRadiance(benchmark::State& state) {
  std::size_t n = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Hall().renderer().RenderRadiance(CameraPose(n += 7)));
  }
}
BENCHMARK(RenderRadiance)->Unit(benchmark::kMillisecond);

void RenderRange(benchmark::State& state) {
  std::size_t n = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Hall().renderer().RenderRange(CameraPose(n += 7)));
  }
}
BENCHMARK(RenderRange)->Unit(benchmark::kMillisecond);

void TrackFrame(benchmark::State& state) {
  const Simulator& hall = Hall();
  ImageSensor sensor(hall.options().sensor, *hall.camera(), 1);
  VioFrontEnd front_end(
      hall.world(), hall.camera(), sim::SimulatedExtrinsic(), hall.options().vio, 1);
  std::size_t n = 0;
  for (auto _ : state) {
    state.PauseTiming();
    VioFrame frame;
    frame.stamp_ns = static_cast<std::int64_t>(++n) * 100000000;
    frame.T_W_B = CameraPose(n) * sim::SimulatedExtrinsic().Inverse();
    frame.T_V_B = frame.T_W_B;
    frame.image = sensor.Expose(hall.renderer().RenderRadiance(CameraPose(n)));
    state.ResumeTiming();
    benchmark::DoNotOptimize(front_end.Process(frame));
  }
}
BENCHMARK(TrackFrame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deja_view::sim
