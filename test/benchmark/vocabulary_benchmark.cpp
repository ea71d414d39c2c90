// Words of 1000 descriptors, opening a file and training.
//
// Descriptors are those of the tree's own leaves with some bits turned over, so that they reach all
// parts of it, as those of real images do.

#include "deja_view/vocabulary/vocabulary.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"
#include "deja_view/vocabulary/vocabulary_training.hpp"

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "random_vocabulary.hpp"
#include <benchmark/benchmark.h>
#ifdef DEJA_VIEW_HAVE_HIGHWAY
#include <hwy/targets.h>
#endif
#include <unistd.h>

namespace deja_view {
namespace {

constexpr std::size_t kImages = 64;
constexpr std::size_t kFeatures = 1000;

std::vector<std::vector<Descriptor>> MakeImages(const Vocabulary& vocabulary) {
  std::mt19937_64 rng(1);
  std::vector<std::vector<Descriptor>> images(kImages);
  for (auto& image : images) {
    for (std::size_t i = 0; i < kFeatures; ++i) {
      const auto word = static_cast<WordId>(rng() % vocabulary.word_count());
      image.push_back(test::Disturb(vocabulary.Centroid(word), 25, &rng));
    }
  }
  return images;
}

// The full tree of k = 10, L = 6: a million words, 43 MB.
std::shared_ptr<const Vocabulary> FullTree() {
  static const auto vocabulary = Vocabulary::FromTree(test::RandomTree(10, 6, 1));
  return vocabulary;
}

std::shared_ptr<const Vocabulary> Shipped() {
  static const auto vocabulary = Vocabulary::Open(DEJA_VIEW_VOCABULARY);
  return vocabulary;
}

void Words(benchmark::State& state, const std::shared_ptr<const Vocabulary>& vocabulary) {
  const auto images = MakeImages(*vocabulary);
  std::vector<WordId> words;
  std::size_t i = 0;
  for (auto _ : state) {
    vocabulary->Words(images[i++ % kImages], &words);
    benchmark::DoNotOptimize(words.data());
  }
}
void WordsShipped(benchmark::State& state) {
  Words(state, Shipped());
}
void WordsFullTree(benchmark::State& state) {
  Words(state, FullTree());
}
BENCHMARK(WordsShipped)->Unit(benchmark::kMicrosecond);
BENCHMARK(WordsFullTree)->Unit(benchmark::kMicrosecond);

#ifdef DEJA_VIEW_HAVE_HIGHWAY
// As on a CPU without AVX-512.
void WordsAvx2(benchmark::State& state) {
  hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & ~(HWY_AVX3 | HWY_AVX3_DL));
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  const auto vocabulary = Vocabulary::Open(DEJA_VIEW_VOCABULARY);
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  Words(state, vocabulary);
}
BENCHMARK(WordsAvx2)->Unit(benchmark::kMicrosecond);
#endif

void Bag(benchmark::State& state) {
  const auto images = MakeImages(*Shipped());
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Shipped()->Bag(images[i++ % kImages]));
  }
}
BENCHMARK(Bag)->Unit(benchmark::kMicrosecond);

void OpenShipped(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(Vocabulary::Open(DEJA_VIEW_VOCABULARY));
  }
}
BENCHMARK(OpenShipped)->Unit(benchmark::kMicrosecond);

void OpenFullTree(benchmark::State& state) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("deja_view_vocabulary_benchmark" + std::to_string(::getpid()) + ".dvv");
  WriteFlatVocabulary(path, FullTree()->ToTree());
  for (auto _ : state) {
    benchmark::DoNotOptimize(Vocabulary::Open(path));
  }
  std::filesystem::remove(path);
}
BENCHMARK(OpenFullTree)->Unit(benchmark::kMicrosecond);

// 800,000 descriptors, k = 10, L = 6, all cores.
void Train(benchmark::State& state) {
  const auto few = MakeImages(*Shipped());
  std::mt19937_64 rng(2);
  std::vector<std::vector<Descriptor>> images(800);
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (const Descriptor& descriptor : few[i % few.size()]) {
      images[i].push_back(test::Disturb(descriptor, 20, &rng));
    }
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(TrainVocabulary(images, TrainOptions{}));
  }
}
BENCHMARK(Train)->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime();

}  // namespace
}  // namespace deja_view
