#include "kmeans.hpp"

#include <random>

#include "bit_counter.hpp"
#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

// `groups` random centres with descriptors around them, mixed.
std::vector<Descriptor> Groups(int groups, int size, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<Descriptor> centres;
  for (int i = 0; i < groups; ++i) {
    centres.push_back(test::RandomDescriptor(&rng));
  }
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < groups * size; ++i) {
    descriptors.push_back(test::Disturb(centres[i % groups], 12, &rng));
  }
  return descriptors;
}

TEST(KMeans, FindsGroups) {
  std::vector<Descriptor> descriptors = Groups(5, 40, 1);
  KMeansOptions options;
  options.k = 5;
  const std::vector<Cluster> clusters = KMeans(options, descriptors.data(), descriptors.size());
  ASSERT_EQ(clusters.size(), 5U);
  std::size_t end = 0;
  for (const Cluster& cluster : clusters) {
    EXPECT_EQ(cluster.begin, end);
    EXPECT_EQ(cluster.end - cluster.begin, 40U);
    end = cluster.end;
    for (std::size_t i = cluster.begin; i < cluster.end; ++i) {
      EXPECT_LT(HammingDistance(descriptors[i], cluster.centre), 30);
    }
  }
}

TEST(KMeans, EveryDescriptorIsWithTheFirstNearestCentre) {
  std::vector<Descriptor> descriptors = Groups(300, 2, 2);
  KMeansOptions options;
  options.k = 7;
  options.iterations = 2;  // stops before it has converged
  const std::vector<Cluster> clusters = KMeans(options, descriptors.data(), descriptors.size());
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    for (std::size_t i = clusters[c].begin; i < clusters[c].end; ++i) {
      const int distance = HammingDistance(descriptors[i], clusters[c].centre);
      for (std::size_t other = 0; other < clusters.size(); ++other) {
        const int to_other = HammingDistance(descriptors[i], clusters[other].centre);
        EXPECT_TRUE(other < c ? distance < to_other : distance <= to_other);
      }
    }
  }
}

TEST(KMeans, DoesNotDependOnThreads) {
  const std::vector<Descriptor> descriptors = Groups(300, 100, 3);  // several chunks
  KMeansOptions options;
  std::vector<Descriptor> expected = descriptors;
  const std::vector<Cluster> one = KMeans(options, expected.data(), expected.size());
  for (const int threads : {2, 3}) {
    options.threads = threads;
    std::vector<Descriptor> sorted = descriptors;
    const std::vector<Cluster> many = KMeans(options, sorted.data(), sorted.size());
    EXPECT_EQ(sorted, expected);
    ASSERT_EQ(many.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(many[i].centre, one[i].centre);
      EXPECT_EQ(many[i].end, one[i].end);
    }
  }
}

TEST(KMeans, FewDistinctDescriptorsBecomeTheCentres) {
  std::mt19937_64 rng(4);
  const Descriptor a = test::RandomDescriptor(&rng);
  const Descriptor b = test::RandomDescriptor(&rng);
  std::vector<Descriptor> descriptors = {a, b, a, a, b};
  EXPECT_EQ(KMeans({}, descriptors.data(), descriptors.size()).size(), 2U);
  std::vector<Descriptor> equal = {a, a, a};
  const std::vector<Cluster> clusters = KMeans({}, equal.data(), equal.size());
  ASSERT_EQ(clusters.size(), 1U);
  EXPECT_EQ(clusters[0].centre, a);
}

TEST(BitCounter, FindsTheMajority) {
  std::mt19937_64 rng(5);
  for (const int count : {1, 2, 3, 254, 255, 256, 700}) {
    BitCounter counter;
    BitCounter second;
    std::vector<int> counts(256, 0);
    for (int i = 0; i < count; ++i) {
      const Descriptor descriptor = test::RandomDescriptor(&rng);
      (i % 3 == 0 ? second : counter).Add(descriptor);
      for (std::size_t bit = 0; bit < 256; ++bit) {
        counts[bit] += static_cast<int>(descriptor.words[bit / 64] >> (bit % 64) & 1U);
      }
    }
    counter.Add(second);
    EXPECT_EQ(counter.count(), static_cast<std::uint64_t>(count));
    const Descriptor majority = counter.Majority();
    for (std::size_t bit = 0; bit < 256; ++bit) {
      EXPECT_EQ(majority.words[bit / 64] >> (bit % 64) & 1U, 2 * counts[bit] >= count ? 1U : 0U);
    }
  }
}

}  // namespace
}  // namespace deja_view::internal
