#include "deja_view/place/place_database.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "random_vocabulary.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::RandomBow;

std::shared_ptr<const Vocabulary> MakeVocabulary() {
  return Vocabulary::FromTree(test::RandomTree(10, 3, 1));
}

PlaceDatabaseOptions MakeOptions(const std::string& score, const std::string& idf) {
  PlaceDatabaseOptions options;
  options.score = score;
  options.idf = idf;
  return options;
}

// Compares with PlaceDatabase::Score of every entry.
class Reference {
 public:
  void Add(int id, int tag, const BowVector& bow) { entries_[{id, tag}] = bow; }

  void Remove(int id) {
    entries_.erase(entries_.lower_bound({id, std::numeric_limits<int>::min()}),
                   entries_.upper_bound({id, std::numeric_limits<int>::max()}));
  }

  std::vector<PlaceMatch> Query(const PlaceDatabase& database,
                                const BowVector& bow,
                                const PlaceQuery& query) const {
    std::vector<PlaceMatch> matches;
    for (const auto& [key, entry] : entries_) {
      const double score = database.Score(bow, entry);
      if (key.first >= query.min_id && key.first <= query.max_id && score > 0 &&
          score >= query.min_score) {
        matches.push_back({key.first, key.second, score});
      }
    }
    std::stable_sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
      return a.score > b.score;
    });
    if (query.best_per_id) {
      std::set<int> seen;
      matches.erase(std::remove_if(matches.begin(),
                                   matches.end(),
                                   [&](const PlaceMatch& m) { return !seen.insert(m.id).second; }),
                    matches.end());
    }
    matches.resize(std::min(matches.size(), static_cast<std::size_t>(query.max_results)));
    return matches;
  }

 private:
  std::map<std::pair<int, int>, BowVector> entries_;
};

void ExpectSame(const std::vector<PlaceMatch>& found, const std::vector<PlaceMatch>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].id, expected[i].id) << "rank " << i;
    EXPECT_EQ(found[i].tag, expected[i].tag) << "rank " << i;
    EXPECT_EQ(found[i].score, expected[i].score) << "rank " << i;  // every bit
  }
}

class PlaceDatabaseModes : public ::testing::TestWithParam<std::tuple<const char*, const char*>> {
 protected:
  PlaceDatabase MakeDatabase() const {
    return {MakeOptions(std::get<0>(GetParam()), std::get<1>(GetParam())), MakeVocabulary()};
  }
};

INSTANTIATE_TEST_SUITE_P(All,
                         PlaceDatabaseModes,
                         ::testing::Combine(::testing::Values("l1", "cosine"),
                                            ::testing::Values("frozen", "running")));

TEST_P(PlaceDatabaseModes, AgreesWithBruteForceThroughAddsAndRemovals) {
  PlaceDatabase database = MakeDatabase();
  Reference reference;
  std::mt19937_64 rng(7);
  // Sizes from nearly nothing to far above the query's: every branch of the L1 sums.
  const std::vector<std::size_t> sizes = {1, 30, 150, 300, 400, 700, 1500};
  int next_id = 0;
  for (int step = 0; step < 260; ++step) {
    if (step % 4 == 3) {
      const int id = static_cast<int>(rng() % static_cast<std::uint64_t>(next_id));
      reference.Remove(id);
      database.Remove(id);
    } else {
      const int tags = step % 3 == 0 ? 3 : 1;
      for (int tag = 0; tag < tags; ++tag) {
        const BowVector bow = RandomBow(sizes[rng() % sizes.size()], 1000, &rng);
        reference.Add(next_id, tag, bow);
        database.Add(next_id, bow, tag);
      }
      ++next_id;
    }
    if (step % 10 == 0) {
      PlaceQuery query;
      query.max_results = step % 20 == 0 ? 1000 : 8;
      query.min_id = step % 30 == 0 ? 5 : 0;
      query.max_id = step % 40 == 0 ? next_id - 6 : next_id;
      query.best_per_id = step % 50 < 20;
      const BowVector bow = RandomBow(sizes[rng() % sizes.size()], 1000, &rng);
      ExpectSame(database.Query(bow, query), reference.Query(database, bow, query));
    }
  }
}

TEST_P(PlaceDatabaseModes, AnImageIsMostLikeItself) {
  PlaceDatabase database = MakeDatabase();
  std::mt19937_64 rng(3);
  std::vector<BowVector> bows;
  for (int id = 0; id < 20; ++id) {
    bows.push_back(RandomBow(300, 1000, &rng));
    database.Add(id, bows.back());
  }
  for (int id = 0; id < 20; ++id) {
    const std::vector<PlaceMatch> matches = database.Query(bows[id], {});
    ASSERT_FALSE(matches.empty());
    EXPECT_EQ(matches[0].id, id);
    EXPECT_NEAR(matches[0].score, 1.0, 1e-12);
  }
}

TEST_P(PlaceDatabaseModes, EqualScoresAreOrderedByIdAndTag) {
  PlaceDatabase database = MakeDatabase();
  std::mt19937_64 rng(3);
  const BowVector bow = RandomBow(300, 1000, &rng);
  const BowVector other = RandomBow(300, 1000, &rng);
  database.Add(9, bow);
  database.Add(4, bow, 1);
  database.Add(4, bow, 0);
  database.Add(1, other);
  PlaceQuery query;
  query.max_results = 2;
  const std::vector<PlaceMatch> matches = database.Query(bow, query);
  ASSERT_EQ(matches.size(), 2U);
  EXPECT_EQ(std::tie(matches[0].id, matches[0].tag), std::make_tuple(4, 0));
  EXPECT_EQ(std::tie(matches[1].id, matches[1].tag), std::make_tuple(4, 1));
}

TEST_P(PlaceDatabaseModes, LeavesOutWhatIsBelowTheMinimum) {
  PlaceDatabase database = MakeDatabase();
  std::mt19937_64 rng(5);
  for (int id = 0; id < 30; ++id) {
    database.Add(id, RandomBow(300, 1000, &rng));
  }
  const BowVector bow = RandomBow(300, 1000, &rng);
  PlaceQuery query;
  query.max_results = 30;
  const std::vector<PlaceMatch> all = database.Query(bow, query);
  ASSERT_EQ(all.size(), 30U);
  query.min_score = all[11].score;
  EXPECT_EQ(database.Query(bow, query).size(), 12U);
}

TEST_P(PlaceDatabaseModes, AnEmptyDatabaseOrQueryFindsNothing) {
  PlaceDatabase database = MakeDatabase();
  std::mt19937_64 rng(5);
  EXPECT_TRUE(database.Query(RandomBow(100, 1000, &rng), {}).empty());
  database.Add(1, RandomBow(100, 1000, &rng));
  database.Add(2, BowVector{});
  EXPECT_TRUE(database.Query(BowVector{}, {}).empty());
  EXPECT_EQ(database.Query(RandomBow(100, 1000, &rng), {}).size(), 1U);
  EXPECT_TRUE(database.Remove(2));
  EXPECT_FALSE(database.Remove(2));
  EXPECT_EQ(database.size(), 1U);
}

TEST_P(PlaceDatabaseModes, RepeatedWordsCount) {
  PlaceDatabase database = MakeDatabase();
  BowVector many;
  many.entries = {{10, 300}, {20, 3}, {30, 1}};
  many.descriptor_count = 304;
  BowVector few;
  few.entries = {{10, 2}, {20, 3}, {40, 1}};
  few.descriptor_count = 6;
  database.Add(0, many);
  database.Add(1, few);
  for (const BowVector& bow : {many, few}) {
    const std::vector<PlaceMatch> matches = database.Query(bow, {});
    ASSERT_EQ(matches.size(), 2U);
    for (const PlaceMatch& match : matches) {
      EXPECT_EQ(match.score, database.Score(bow, match.id == 0 ? many : few));
    }
  }
}

TEST(PlaceDatabase, RunningIdfFollowsTheContent) {
  PlaceDatabase database(MakeOptions("l1", "running"), MakeVocabulary());
  BowVector a;
  a.entries = {{1, 1}, {2, 1}};
  a.descriptor_count = 2;
  BowVector b;
  b.entries = {{1, 1}, {3, 1}};
  b.descriptor_count = 2;
  database.Add(0, a);
  database.Add(1, b);
  // N + 1 = 3; df of words 1, 2, 3 is 2, 1, 1. In common: word 1.
  const double w1 = std::log(3.0 / 2.0);
  const double w2 = std::log(3.0);
  EXPECT_NEAR(database.Score(a, b), w1 / (w1 + w2), 1e-3);
  database.Remove(1);
  // N + 1 = 2; df 1, 1, 0.
  EXPECT_NEAR(database.Score(a, b), 0.5, 1e-3);
}

TEST(PlaceDatabase, ChecksItsInput) {
  PlaceDatabase database(PlaceDatabaseOptions{}, MakeVocabulary());
  BowVector bow;
  bow.entries = {{1000, 1}};
  EXPECT_THROW(database.Add(0, bow), CheckError);  // no such word
  bow.entries = {{5, 1}, {5, 1}};
  EXPECT_THROW(database.Add(0, bow), CheckError);  // not sorted
  bow.entries = {{5, 1}};
  database.Add(0, bow);
  EXPECT_THROW(database.Add(0, bow), CheckError);  // twice
  EXPECT_THROW(PlaceDatabase(MakeOptions("l3", "frozen"), MakeVocabulary()), CheckError);
  EXPECT_EQ(MakeOptions("l3", "thawed").Validate().size(), 2U);
}

TEST(PlaceDatabase, TellsItsMemory) {
  PlaceDatabase database(PlaceDatabaseOptions{}, MakeVocabulary());
  const std::size_t empty = database.memory_bytes();
  std::mt19937_64 rng(5);
  for (int id = 0; id < 100; ++id) {
    database.Add(id, RandomBow(300, 1000, &rng));
  }
  EXPECT_GT(database.memory_bytes(), empty + 100 * 300);
}

}  // namespace
}  // namespace deja_view
