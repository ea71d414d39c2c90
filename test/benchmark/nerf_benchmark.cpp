// Speed of the radiance field's kernels and of whole training steps.
#include "deja_view/nerf/kernels.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "test_cameras.hpp"
#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

namespace deja_view::nerf {
namespace {

constexpr std::size_t kSamples = 4096;

std::vector<float> RandomFloats(std::size_t count) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<float> values(count);
  for (float& value : values) {
    value = uniform(rng);
  }
  return values;
}

/// What the machine allows a lookup: sums of lines of 32 bytes at random places of 128 MiB, with
/// nothing computed but the places. Items are lines.
void RandomLines(benchmark::State& state) {
  constexpr std::size_t kLine = 8;
  FloatArray table(std::size_t{1} << 25U);
  std::vector<std::uint32_t> places(1U << 16U);
  std::mt19937 rng(1);
  for (std::uint32_t& place : places) {
    place = static_cast<std::uint32_t>(rng() % (table.size() / kLine) * kLine);
  }
  for (auto _ : state) {
    std::array<float, kLine> sum{};
    for (const std::uint32_t place : places) {
      for (std::size_t i = 0; i < kLine; ++i) {
        sum[i] += table[place + i];
      }
    }
    benchmark::DoNotOptimize(sum.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(places.size()));
}
BENCHMARK(RandomLines);

/// One hashed level of 2^log2 entries; argument 0: kernels, 1: log2 of the entries, 2: features.
GridLevel MakeLevel(const benchmark::State& state) {
  GridLevel level;
  level.scale = 1024;
  level.hashed = true;
  level.features = static_cast<int>(state.range(2));
  level.bricks = (1U << static_cast<unsigned>(state.range(1))) / 8;
  level.mask = level.bricks - 1;
  return level;
}

const Kernels* PickKernels(benchmark::State& state) {
  const std::vector<const Kernels*> kernels = AvailableKernels();
  const auto index = static_cast<std::size_t>(state.range(0));
  if (index >= kernels.size()) {
    state.SkipWithError("no such kernels here");
    return nullptr;
  }
  state.SetLabel(kernels[index]->name);
  return kernels[index];
}

void GridForward(benchmark::State& state) {
  const Kernels* kernels = PickKernels(state);
  if (kernels == nullptr) {
    return;
  }
  const GridLevel level = MakeLevel(state);
  const std::vector<float> table =
      RandomFloats(std::size_t{8} * level.bricks * static_cast<std::size_t>(level.features));
  const std::vector<float> p = RandomFloats(3 * kSamples);
  std::vector<float> out(kSamples * 4);
  for (auto _ : state) {
    kernels->grid_forward(level,
                          table.data(),
                          {p.data(), p.data() + kSamples, p.data() + 2 * kSamples},
                          kSamples,
                          out.data(),
                          4);
    benchmark::DoNotOptimize(out.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kSamples));
}
BENCHMARK(GridForward)->ArgsProduct({{0, 1, 2, 3, 4}, {16, 19, 21}, {2, 4}});

void GridBackward(benchmark::State& state) {
  const Kernels* kernels = PickKernels(state);
  if (kernels == nullptr) {
    return;
  }
  const GridLevel level = MakeLevel(state);
  std::vector<float> gradient(std::size_t{8} * level.bricks *
                              static_cast<std::size_t>(level.features));
  std::vector<std::uint8_t> touched(level.bricks);
  const std::vector<float> p = RandomFloats(3 * kSamples);
  const std::vector<float> d = RandomFloats(kSamples * 4);
  for (auto _ : state) {
    kernels->grid_backward(level,
                           {p.data(), p.data() + kSamples, p.data() + 2 * kSamples},
                           kSamples,
                           d.data(),
                           gradient.data(),
                           touched.data());
    benchmark::DoNotOptimize(gradient.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kSamples));
}
BENCHMARK(GridBackward)->ArgsProduct({{0, 1, 2, 3, 4}, {16, 19, 21}, {2, 4}});

void LayerForward(benchmark::State& state) {
  const Kernels* kernels = PickKernels(state);
  if (kernels == nullptr) {
    return;
  }
  const LayerShape shape{32, 32};
  const std::vector<float> weights = RandomFloats(32 * 32);
  const std::vector<float> bias = RandomFloats(32);
  const std::vector<float> x = RandomFloats(kSamples * 32);
  std::vector<float> y(kSamples * 32);
  for (auto _ : state) {
    kernels->layer_forward(shape, weights.data(), bias.data(), x.data(), kSamples, true, y.data());
    benchmark::DoNotOptimize(y.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kSamples));
}
BENCHMARK(LayerForward)->DenseRange(0, 4);

/// Steps on noise images, which never leave the fog: every sample is coloured. Argument: threads.
void TrainingStep(benchmark::State& state) {
  const auto camera = SharedPinholeOf(188, 120, 115, 93.5, 59.5);
  std::vector<TrainingView> views(32);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double u = static_cast<double>(i);
    views[i].camera = camera;
    views[i].image.create(camera->height(), camera->width(), CV_8UC1);
    cv::randu(views[i].image, 0, 255);
    views[i].T_N_C = {ExpSo3({0, 0.4 * u, 0}), {std::sin(u), 0, std::cos(u)}};
  }
  SceneBox box;
  box.min.setConstant(-4);
  box.max.setConstant(4);
  TrainOptions options;
  options.threads = static_cast<int>(state.range(0));
  options.warmup_steps = 0;
  Trainer trainer(options, views, box);
  std::size_t samples = 0;
  std::size_t rays = 0;
  for (int i = 0; i < 10; ++i) {
    trainer.Step(0);  // until the number of rays has settled
  }
  for (auto _ : state) {
    const StepReport report = trainer.Step(0);
    samples += report.samples;
    rays += report.rays;
  }
  state.counters["samples/s"] =
      benchmark::Counter(static_cast<double>(samples), benchmark::Counter::kIsRate);
  state.counters["rays/s"] =
      benchmark::Counter(static_cast<double>(rays), benchmark::Counter::kIsRate);
}
BENCHMARK(TrainingStep)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace deja_view::nerf
