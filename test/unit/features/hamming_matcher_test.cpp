#include "deja_view/features/hamming_matcher.hpp"

#include <bitset>
#include <random>

#include "hamming_kernel.hpp"
#include "instruction_sets.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

// Few distinct bits, so that distances tie often.
std::vector<Descriptor> RandomDescriptors(std::size_t count, bool few_bits, std::mt19937_64* rng) {
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (std::uint64_t& word : descriptor.words) {
      word = few_bits ? (*rng)() & 0x8000000000000001U : (*rng)();
    }
  }
  return descriptors;
}

TEST(HammingDistance, CountsBits) {
  std::mt19937_64 rng(1);
  std::vector<Descriptor> descriptors = RandomDescriptors(100, false, &rng);
  descriptors.push_back({});
  descriptors.push_back({{~0ULL, ~0ULL, ~0ULL, ~0ULL}});
  for (const Descriptor& a : descriptors) {
    for (const Descriptor& b : descriptors) {
      std::size_t expected = 0;
      for (std::size_t i = 0; i < a.words.size(); ++i) {
        expected += std::bitset<64>(a.words[i] ^ b.words[i]).count();
      }
      EXPECT_EQ(HammingDistance(a, b), static_cast<int>(expected));
    }
  }
}

void ExpectAgreement() {
  std::mt19937_64 rng(1);
  for (const bool few_bits : {false, true}) {
    for (const std::size_t train_count :
         {0U, 1U, 2U, 3U, 4U, 7U, 8U, 9U, 15U, 16U, 17U, 63U, 1001U}) {
      const auto queries = RandomDescriptors(23, few_bits, &rng);
      const auto train = RandomDescriptors(train_count, few_bits, &rng);
      for (const int cap : {256, 120, 3, 0}) {
        std::vector<HammingMatch> expected(queries.size());
        internal::MatchHammingPortable(
            {queries.data(), queries.size(), train.data(), train.size(), cap, expected.data()});
        EXPECT_EQ(MatchHamming(queries, train, cap), expected) << train_count << " cap " << cap;
      }
    }
  }
}

TEST(HammingMatcher, AgreesWithThePlainLoopOnEveryInstructionSet) {
  test::OnEveryInstructionSet(ExpectAgreement);
}

TEST(HammingMatcher, FindsTheTwoNearest) {
  std::vector<Descriptor> train(40);
  for (Descriptor& descriptor : train) {
    descriptor.words = {~0ULL, ~0ULL, ~0ULL, ~0ULL};
  }
  train[33].words = {0, 0, 7, 0};
  train[5].words = {1, 0, 0, 0};
  const std::vector<HammingMatch> matches = MatchHamming({Descriptor{}}, train);
  EXPECT_EQ(matches.at(0), (HammingMatch{5, 1, 33, 3}));
  EXPECT_EQ(MatchHamming({Descriptor{}}, train, 2).at(0), (HammingMatch{5, 1, -1, 257}));
  EXPECT_EQ(MatchHamming({Descriptor{}}, train, 0).at(0), (HammingMatch{}));
}

TEST(HammingMatcher, TiesGoToTheLowerIndex) {
  const std::vector<Descriptor> train(100);
  EXPECT_EQ(MatchHamming({Descriptor{}}, train).at(0), (HammingMatch{0, 0, 1, 0}));
  Descriptor opposite;
  opposite.words = {~0ULL, ~0ULL, ~0ULL, ~0ULL};
  EXPECT_EQ(MatchHamming({opposite}, train).at(0), (HammingMatch{0, 256, 1, 256}));
}

}  // namespace
}  // namespace deja_view
