#include "deja_view/appearance/appearance_places.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <utility>

namespace deja_view {
namespace {

using Clock = std::chrono::steady_clock;

double Since(Clock::time_point* start) {
  const auto now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - *start).count();
  *start = now;
  return seconds;
}

}  // namespace

std::vector<std::string> AppearancePlacesOptions::Validate() const {
  Requirements r;
  r.Group("two_view", two_view.Validate());
  r.Group("database", database.Validate());
  r.That(min_gap >= 1, "min_gap", min_gap, "at least 1");
  r.That(max_results >= 1, "max_results", max_results, "at least 1");
  r.That(island_gap >= 1, "island_gap", island_gap, "at least 1");
  r.That(max_islands >= 1, "max_islands", max_islands, "at least 1");
  r.That(consistency >= 0, "consistency", consistency, "at least 0");
  r.That(consistency_gap >= 1, "consistency_gap", consistency_gap, "at least 1");
  r.That(threads >= 0, "threads", threads, "at least 0");
  return r.errors();
}

std::vector<PlaceIsland> GroupIslands(std::vector<PlaceMatch> matches, int island_gap) {
  std::sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
    return a.id < b.id;
  });
  std::vector<PlaceIsland> islands;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (i == 0 || matches[i].id - matches[i - 1].id > island_gap) {
      islands.emplace_back();
    }
    PlaceIsland& island = islands.back();
    island.support += matches[i].score;
    if (matches[i].score > island.score) {
      island.id = matches[i].id;
      island.score = matches[i].score;
    }
  }
  std::stable_sort(islands.begin(), islands.end(), [](const PlaceIsland& a, const PlaceIsland& b) {
    return a.support > b.support;
  });
  return islands;
}

AppearancePlaces::AppearancePlaces(const AppearancePlacesOptions& options,
                                   std::shared_ptr<const Vocabulary> vocabulary)
    : options_(options),
      vocabulary_(std::move(vocabulary)),
      database_(options.database, vocabulary_) {
  DEJA_VIEW_CHECK(options.Validate().empty());
}

AppearanceMatch AppearancePlaces::Add(Features features, AppearanceTimes* times) {
  auto start = Clock::now();
  AppearanceTimes spent;
  const int id = size();
  const BowVector bow = vocabulary_->Bag(features.descriptors);
  spent.words = Since(&start);
  PlaceQuery query;
  query.max_results = options_.max_results;
  query.max_id = id - options_.min_gap;
  std::vector<PlaceIsland> islands;
  if (query.max_id >= 0) {
    islands = GroupIslands(database_.Query(bow, query), options_.island_gap);
  }
  islands.resize(std::min(islands.size(), static_cast<std::size_t>(options_.max_islands)));
  database_.Add(id, bow);
  spent.query = Since(&start);
  AppearanceMatch match = BestOf(islands, features);
  match.score = Score(match);
  images_.push_back(std::move(features));
  found_.push_back(match);
  spent.two_view = Since(&start);
  if (times != nullptr) {
    *times = spent;
  }
  return match;
}

AppearanceMatch AppearancePlaces::BestOf(const std::vector<PlaceIsland>& islands,
                                         const Features& features) const {
  std::vector<TwoViewResult> results(islands.size());
  ParallelFor(options_.threads, islands.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Features& other = images_[static_cast<std::size_t>(islands[i].id)];
      results[i] = CompareTwoViews(features, other, options_.two_view);
    }
  });
  AppearanceMatch best;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    if (results[i].inliers > best.inliers) {
      best.id = islands[i].id;
      best.similarity = islands[i].score;
      best.matches = results[i].matches;
      best.inliers = results[i].inliers;
    }
  }
  return best;
}

double AppearancePlaces::Score(const AppearanceMatch& match) const {
  int fewest = match.inliers;
  int id = match.id;
  for (int back = 1; back <= options_.consistency; ++back) {
    if (static_cast<std::size_t>(back) > found_.size()) {
      return 0;
    }
    const AppearanceMatch& before = found_[found_.size() - static_cast<std::size_t>(back)];
    if (before.id < 0 || std::abs(before.id - id) > options_.consistency_gap) {
      return 0;
    }
    fewest = std::min(fewest, before.inliers);
    id = before.id;
  }
  return fewest;
}

}  // namespace deja_view
