// Feature extraction and descriptor matching on synthetic data, one thread.
#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/features/hamming_matcher.hpp"

#include <random>

#include "synthetic_image.hpp"
#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

void BM_Brief(benchmark::State& state) {
  cv::setNumThreads(1);
  const cv::Mat image = test::SyntheticImage(752, 480, 1);
  BriefOptions options;
  options.max_features = static_cast<int>(state.range(0));
  const BriefExtractor extractor(options);
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  std::vector<cv::Point2f> points(150);
  for (cv::Point2f& point : points) {
    point = {uniform(rng) * 751, uniform(rng) * 479};
  }
  std::vector<Descriptor> descriptors;
  std::size_t count = 0;
  for (auto _ : state) {
    count = extractor.Extract(image, points, &descriptors).keypoints.size();
  }
  state.counters["features"] = static_cast<double>(count);
}
BENCHMARK(BM_Brief)->Arg(1000)->Unit(benchmark::kMillisecond);

void BM_BriefSmoothing(benchmark::State& state) {
  cv::setNumThreads(1);
  const cv::Mat image = test::SyntheticImage(752, 480, 1);
  cv::Mat smooth;
  for (auto _ : state) {
    cv::GaussianBlur(image, smooth, {9, 9}, 2, 2);
    benchmark::DoNotOptimize(smooth.data);
  }
}
BENCHMARK(BM_BriefSmoothing)->Unit(benchmark::kMillisecond);

void BM_Fast(benchmark::State& state) {
  cv::setNumThreads(1);
  const cv::Mat image = test::SyntheticImage(752, 480, 1);
  std::vector<cv::KeyPoint> corners;
  for (auto _ : state) {
    cv::FAST(image, corners, 20, true, cv::FastFeatureDetector::TYPE_9_16);
  }
  state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(BM_Fast)->Unit(benchmark::kMillisecond);

std::vector<Descriptor> RandomDescriptors(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (std::uint64_t& word : descriptor.words) {
      word = rng();
    }
  }
  return descriptors;
}

void BM_MatchHamming(benchmark::State& state) {
  const auto queries = RandomDescriptors(static_cast<std::size_t>(state.range(0)), 1);
  const auto train = RandomDescriptors(static_cast<std::size_t>(state.range(1)), 2);
  for (auto _ : state) {
    benchmark::DoNotOptimize(MatchHamming(queries, train));
  }
}
BENCHMARK(BM_MatchHamming)->Args({150, 1000})->Unit(benchmark::kMicrosecond);

void BM_MatchHammingPortable(benchmark::State& state) {
  const auto queries = RandomDescriptors(150, 1);
  const auto train = RandomDescriptors(1000, 2);
  std::vector<HammingMatch> matches(queries.size());
  for (auto _ : state) {
    internal::MatchHammingPortable(
        queries.data(), queries.size(), train.data(), train.size(), 256, matches.data());
    benchmark::DoNotOptimize(matches.data());
  }
}
BENCHMARK(BM_MatchHammingPortable)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace deja_view
