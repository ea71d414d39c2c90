// Loading a saved map of so many places with 500 corners and 100 points each, of a flight that goes
// on and on. Counters: processor time of all threads [s]; per place [kB] the file's size, and what
// is resident once it is loaded.
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <ctime>
#include <filesystem>
#include <memory>
#include <random>
#include <string>

#include "map_io.hpp"
#include "random_vocabulary.hpp"
#include "resident_memory.hpp"
#include <benchmark/benchmark.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

constexpr int kCorners = 500;
constexpr int kPoints = 100;

std::shared_ptr<const Camera> MakeBenchmarkCamera() {
  PinholeParameters parameters;
  parameters.width = 752;
  parameters.height = 480;
  parameters.fx = parameters.fy = 460;
  parameters.cx = 376;
  parameters.cy = 240;
  return std::make_shared<PinholeCamera>(parameters);
}

Descriptor AWord(const Vocabulary& vocabulary, std::mt19937_64* rng) {
  const auto word = static_cast<WordId>((*rng)() % vocabulary.word_count());
  return test::Disturb(vocabulary.Centroid(word), 12, rng);
}

KeyframeFeatures MakePlaceFeatures(const Vocabulary& vocabulary, std::mt19937_64* rng) {
  const auto pixel = [&] {
    return Eigen::Vector2f(static_cast<float>((*rng)() % 752), static_cast<float>((*rng)() % 480));
  };
  KeyframeFeatures f;
  for (int i = 0; i < kCorners; ++i) {
    f.keypoints.push_back(pixel());
    f.descriptors.push_back(AWord(vocabulary, rng));
  }
  for (int i = 0; i < kPoints; ++i) {
    f.points_B.emplace_back(1.0F, 0.0F, 5.0F);
    f.point_pixels.push_back(pixel());
    f.point_depth_sigmas.push_back(0.1F);
    f.point_ids.push_back(i);
    f.point_descriptors.push_back(AWord(vocabulary, rng));
  }
  return f;
}

void WriteLongMap(const fs::path& directory,
                  int places,
                  const Camera& camera,
                  const std::shared_ptr<const Vocabulary>& vocabulary) {
  std::mt19937_64 rng(1);
  KeyframeMap keyframes{PoseGraphOptions{}};
  for (int i = 0; i < places; ++i) {
    StoredKeyframe keyframe;
    keyframe.stamp_ns = 1'600'000'000'000'000'000 + std::int64_t{500'000'000} * i;
    keyframes.Add(keyframe, 0, {Eigen::Quaterniond::Identity(), {0.5 * i, 0, 1}});
    keyframes.MakePlace(MakePlaceFeatures(*vocabulary, &rng));
  }
  const LoopCloserOptions options;
  const PlaceFinder finder(options.place, options.scoring, options.candidates, vocabulary);
  WriteMap(directory, {DescriptorKind(FeatureOptions()), camera, finder}, keyframes, {}, {});
}

void BM_Load(benchmark::State& state) {
  const auto places = static_cast<int>(state.range(0));
  const auto vocabulary = Vocabulary::Open(DEJA_VIEW_VOCABULARY);
  const auto camera = MakeBenchmarkCamera();
  const fs::path directory =
      fs::temp_directory_path() / ("deja_view_map_benchmark_" + std::to_string(::getpid()));
  WriteLongMap(directory, places, *camera, vocabulary);
  const double file_kb = static_cast<double>(fs::file_size(directory / "map.dvm")) / 1024;
  for (auto _ : state) {
    const double before_kb = test::ResidentKb();
    LoopCloser closer({}, camera, Rigid3(), vocabulary);
    const std::clock_t begin = std::clock();
    closer.Load(directory);
    state.counters["cpu_s"] = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    state.counters["resident_kb"] = (test::ResidentKb() - before_kb) / places;
    state.counters["core_kb"] = static_cast<double>(closer.memory_bytes()) / 1024 / places;
  }
  state.counters["file_kb"] = file_kb / places;
  fs::remove_all(directory);
}
BENCHMARK(BM_Load)->Arg(2000)->Arg(20000)->Arg(100000)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace deja_view
