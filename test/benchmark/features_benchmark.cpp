// Feature extraction and descriptor matching on synthetic data, one thread.
#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/features/hamming_matcher.hpp"
#include "deja_view/features/orb_extractor.hpp"

#include <random>

#include "hamming_kernel.hpp"
#include "synthetic_image.hpp"
#include <benchmark/benchmark.h>
#ifdef DEJA_VIEW_HAVE_HIGHWAY
#include <hwy/targets.h>
#endif
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

/// To be worked on by one thread.
cv::Mat Picture() {
  cv::setNumThreads(1);
  return test::SyntheticImage(752, 480, 1);
}

void BM_Brief(benchmark::State& state) {
  const cv::Mat image = Picture();
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
    count = extractor.Extract(image, {}, points, &descriptors).keypoints.size();
  }
  state.counters["features"] = static_cast<double>(count);
}
BENCHMARK(BM_Brief)->Arg(1000)->Unit(benchmark::kMillisecond);

void BM_Orb(benchmark::State& state) {
  const cv::Mat image = Picture();
  OrbOptions options;
  options.quadtree = static_cast<QuadtreeMode>(state.range(0));
  const OrbExtractor extractor(options);
  std::size_t count = 0;
  for (auto _ : state) {
    count = extractor.Extract(image).keypoints.size();
  }
  state.SetLabel(EnumToString(options.quadtree));
  state.counters["features"] = static_cast<double>(count);
}
BENCHMARK(BM_Orb)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void BM_OpenCvOrb(benchmark::State& state) {
  const cv::Mat image = Picture();
  const auto orb = cv::ORB::create(1000, 1.2F, 8, 19, 0, 2, cv::ORB::FAST_SCORE, 31);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  for (auto _ : state) {
    orb->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
  }
}
BENCHMARK(BM_OpenCvOrb)->Unit(benchmark::kMillisecond);

void BM_BriefSmoothing(benchmark::State& state) {
  const cv::Mat image = Picture();
  cv::Mat smooth;
  for (auto _ : state) {
    cv::GaussianBlur(image, smooth, {9, 9}, 2, 2);
    benchmark::DoNotOptimize(smooth.data);
  }
}
BENCHMARK(BM_BriefSmoothing)->Unit(benchmark::kMillisecond);

void BM_Fast(benchmark::State& state) {
  const cv::Mat image = Picture();
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

void MatchOnThisCpu(benchmark::State& state) {
  const auto queries = RandomDescriptors(150, 1);
  const auto train = RandomDescriptors(1000, 2);
  for (auto _ : state) {
    benchmark::DoNotOptimize(MatchHamming(queries, train));
  }
}

void BM_MatchHamming(benchmark::State& state) {
  MatchOnThisCpu(state);
}
BENCHMARK(BM_MatchHamming)->Unit(benchmark::kMicrosecond);

#ifdef DEJA_VIEW_HAVE_HIGHWAY
// As on a CPU without AVX-512.
void BM_MatchHammingAvx2(benchmark::State& state) {
  hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & ~(HWY_AVX3 | HWY_AVX3_DL));
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  state.SetLabel(hwy::TargetName(hwy::SupportedTargets() & -hwy::SupportedTargets()));
  MatchOnThisCpu(state);
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}
BENCHMARK(BM_MatchHammingAvx2)->Unit(benchmark::kMicrosecond);
#endif

void BM_MatchHammingPortable(benchmark::State& state) {
  const auto queries = RandomDescriptors(150, 1);
  const auto train = RandomDescriptors(1000, 2);
  std::vector<HammingMatch> matches(queries.size());
  for (auto _ : state) {
    internal::MatchHammingPortable(
        {queries.data(), queries.size(), train.data(), train.size(), 256, matches.data()});
    benchmark::DoNotOptimize(matches.data());
  }
}
BENCHMARK(BM_MatchHammingPortable)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace deja_view
