// Queries and insertions of the place database with keyframes of about 1000 features.
//
// By default words are drawn so that they are as skewed as those of real flights: some are in every
// second image, neighbouring keyframes share most of theirs. With DEJA_VIEW_DATA naming a directory
// that holds hall_a/images and hall_b/images, and DEJA_VIEW_VOCABULARY a BRIEF vocabulary, hall_a's
// images make the map and hall_b's the queries; to have enough keyframes, hall_a is added again and
// again with descriptors disturbed as by another exposure and viewpoint.

#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/place/place_database.hpp"
#include "deja_view/place/scored_places.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "random_vocabulary.hpp"
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

constexpr int kFeatures = 1000;

// Chosen so that a query's words have as many postings as those of hall_b in a map of hall_a.
constexpr double kSkew = 60;

struct Data {
  std::shared_ptr<const Vocabulary> vocabulary;
  std::vector<BowVector> map;
  std::vector<BowVector> queries;
};

// A flight through a world with 80,000 words: a keyframe keeps most of the words of the one before.
std::vector<BowVector> SimulateFlight(std::size_t keyframes, std::uint32_t words, int seed) {
  std::mt19937_64 rng(seed);
  // Word w with a probability like 1 / (w + offset), as in RandomBow; a word's rank says nothing of
  // its number.
  const double offset = words / kSkew;
  const auto draw = [&] {
    const double u = static_cast<double>(rng() >> 11U) * 0x1p-53;
    const double rank = offset * (std::pow((words + offset) / offset, u) - 1);
    return static_cast<WordId>(static_cast<std::uint64_t>(rank) * 40503U % words);
  };
  std::vector<WordId> current(kFeatures);
  std::generate(current.begin(), current.end(), draw);
  std::vector<BowVector> flight;
  for (std::size_t i = 0; i < keyframes; ++i) {
    for (WordId& word : current) {
      word = rng() % 100 < 25 ? draw() : word;
    }
    flight.push_back(CountWords(current));
  }
  return flight;
}

Data Simulate(std::size_t keyframes) {
  Data data;
  data.vocabulary = Vocabulary::FromTree(test::RandomTree(43, 3, 1));  // 79,507 words
  const auto words = static_cast<std::uint32_t>(data.vocabulary->word_count());
  data.map = SimulateFlight(keyframes, words, 1);
  data.queries = SimulateFlight(200, words, 2);
  return data;
}

std::vector<std::vector<Descriptor>> ReadImages(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  const BriefExtractor extractor;
  std::vector<std::vector<Descriptor>> images;
  for (const auto& path : paths) {
    images.push_back(
        extractor.Extract(cv::imread(path.string(), cv::IMREAD_GRAYSCALE)).descriptors);
  }
  return images;
}

Data ReadHalls(const std::filesystem::path& data_dir, std::size_t keyframes) {
  static const auto map = ReadImages(data_dir / "hall_a" / "images");
  static const auto queries = ReadImages(data_dir / "hall_b" / "images");
  Data data;
  data.vocabulary = Vocabulary::Open(DEJA_VIEW_VOCABULARY);
  for (const auto& image : queries) {
    data.queries.push_back(data.vocabulary->Bag(image));
  }
  std::mt19937_64 rng(1);
  for (std::size_t i = 0; i < keyframes; ++i) {
    std::vector<Descriptor> image = map[i % map.size()];
    for (Descriptor& descriptor : image) {
      if (i >= map.size()) {
        descriptor = test::Disturb(descriptor, 12, &rng);
      }
    }
    data.map.push_back(data.vocabulary->Bag(image));
  }
  return data;
}

const Data& GetData(std::size_t keyframes) {
  static std::map<std::size_t, Data> cache;
  const auto found = cache.find(keyframes);
  if (found != cache.end()) {
    return found->second;
  }
  const char* data_dir = std::getenv("DEJA_VIEW_DATA");
  return cache[keyframes] =
             data_dir != nullptr ? ReadHalls(data_dir, keyframes) : Simulate(keyframes);
}

// Made once for each configuration: a benchmark runs several times to find its number of
// iterations.
PlaceDatabase& GetDatabase(const std::string& score,
                           const std::string& idf,
                           std::size_t keyframes) {
  static std::string key;
  static std::unique_ptr<PlaceDatabase> database;
  if (key != fmt::format("{} {} {}", score, idf, keyframes)) {
    key = fmt::format("{} {} {}", score, idf, keyframes);
    const Data& data = GetData(keyframes);
    PlaceDatabaseOptions options;
    options.score = score;
    options.idf = idf;
    database = std::make_unique<PlaceDatabase>(options, data.vocabulary);
    for (std::size_t i = 0; i < keyframes; ++i) {
      database->Add(static_cast<int>(i), data.map[i]);
    }
  }
  return *database;
}

void Query(benchmark::State& state, const std::string& score, const std::string& idf) {
  const auto keyframes = static_cast<std::size_t>(state.range(0));
  const Data& data = GetData(keyframes);
  const PlaceDatabase& database = GetDatabase(score, idf, keyframes);
  PlaceQuery query;
  query.max_results = 50;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(database.Query(data.queries[i++ % data.queries.size()], query));
  }
  std::size_t words = 0;
  for (std::size_t k = 0; k < keyframes; ++k) {
    words += data.map[k].entries.size();
  }
  const PlaceDatabase empty(PlaceDatabaseOptions{}, data.vocabulary);
  const auto per_keyframe = [&](std::size_t x) {
    return static_cast<double>(x) / static_cast<double>(keyframes);
  };
  state.counters["bytes_per_keyframe"] =
      per_keyframe(database.memory_bytes() - empty.memory_bytes());
  state.counters["words_per_keyframe"] = per_keyframe(words);
}

// A keyframe comes and goes.
void AddAndRemove(benchmark::State& state, const std::string& score, const std::string& idf) {
  const auto keyframes = static_cast<std::size_t>(state.range(0));
  const Data& data = GetData(keyframes);
  PlaceDatabase& database = GetDatabase(score, idf, keyframes);
  std::size_t i = 0;
  for (auto _ : state) {
    database.Add(-1, data.queries[i++ % data.queries.size()]);
    database.Remove(-1);
  }
}

// The paper's scoring, of words weighed by tf-idf.
void QueryScored(benchmark::State& state) {
  const auto keyframes = static_cast<std::size_t>(state.range(0));
  const Data& data = GetData(keyframes);
  static std::unique_ptr<ScoredPlaces> places;
  static std::size_t filled = 0;
  ScoringOptions options;
  options.weights = WordWeighting::kTfidf;  // a random vocabulary has no synonyms
  const std::size_t empty_bytes = ScoredPlaces(options, data.vocabulary).memory_bytes();
  if (filled != keyframes) {
    filled = keyframes;
    places = std::make_unique<ScoredPlaces>(options, data.vocabulary);
    for (std::size_t i = 0; i < keyframes; ++i) {
      places->Add(static_cast<int>(i), data.map[i], 0);
    }
  }
  std::size_t i = 0;
  for (auto _ : state) {
    const WeightedBow query = places->Weigh(data.queries[i++ % data.queries.size()]);
    benchmark::DoNotOptimize(places->Query(query, static_cast<int>(keyframes), 20));
  }
  state.counters["bytes_per_keyframe"] =
      static_cast<double>(places->memory_bytes() - empty_bytes) / static_cast<double>(keyframes);
}

BENCHMARK(QueryScored)->Arg(5000)->Arg(20000)->Arg(100000)->Unit(benchmark::kMicrosecond);

void Register(const char* score, const char* idf) {
  const std::string name = fmt::format("{}_{}", score, idf);
  benchmark::RegisterBenchmark(("Query/" + name).c_str(), &Query, score, idf)
      ->Arg(5000)
      ->Unit(benchmark::kMicrosecond);
  benchmark::RegisterBenchmark(("Query/" + name).c_str(), &Query, score, idf)
      ->Arg(20000)
      ->Unit(benchmark::kMicrosecond);
  benchmark::RegisterBenchmark(("AddAndRemove/" + name).c_str(), &AddAndRemove, score, idf)
      ->Arg(20000)
      ->Unit(benchmark::kMicrosecond);
}

const bool kIsRegistered = [] {
  for (const char* score : {"l1", "cosine"}) {
    for (const char* idf : {"frozen", "running"}) {
      Register(score, idf);
    }
  }
  return true;
}();

}  // namespace
}  // namespace deja_view
