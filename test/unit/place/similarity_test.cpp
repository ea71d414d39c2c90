#include "similarity.hpp"

#include <cmath>
#include <random>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

class SimilarityTest : public ::testing::Test {
 protected:
  // Straight from the equations, in floating point over all words.
  double Reference(ScoreKind kind, const BowVector& a, const BowVector& b) const {
    const std::vector<double> x = Dense(a);
    const std::vector<double> y = Dense(b);
    double norm_x = 0;
    double norm_y = 0;
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      norm_x += kind == ScoreKind::kL1 ? x[i] : x[i] * x[i];
      norm_y += kind == ScoreKind::kL1 ? y[i] : y[i] * y[i];
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += kind == ScoreKind::kL1 ? std::abs(x[i] / norm_x - y[i] / norm_y)
                                    : x[i] * y[i] / std::sqrt(norm_x * norm_y);
    }
    return kind == ScoreKind::kL1 ? 1 - 0.5 * sum : sum;
  }

  std::vector<double> Dense(const BowVector& bow) const {
    std::vector<double> dense(vocabulary_->word_count(), 0.0);
    for (const WordCount& entry : bow.entries) {
      dense[entry.word] = double{vocabulary_->Idf(entry.word)} * entry.count;
    }
    return dense;
  }

  std::shared_ptr<const Vocabulary> vocabulary_ = Vocabulary::FromTree(test::RandomTree(10, 2, 1));
  WordWeights weights_{IdfMode::kFrozen, *vocabulary_};
};

TEST_F(SimilarityTest, IsTheEquations) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const BowVector a = test::RandomBow(20 + rng() % 100, 100, &rng);
    const BowVector b = test::RandomBow(20 + rng() % 100, 100, &rng);
    for (const ScoreKind kind : {ScoreKind::kL1, ScoreKind::kCosine}) {
      EXPECT_NEAR(Similarity(kind, weights_, a, b), Reference(kind, a, b), 1e-3);
      EXPECT_EQ(Similarity(kind, weights_, a, b), Similarity(kind, weights_, b, a));
    }
  }
}

TEST_F(SimilarityTest, IsOneForTheSameAndZeroForNothingInCommon) {
  BowVector a;
  a.entries = {{1, 2}, {7, 1}};
  BowVector b;
  b.entries = {{2, 2}, {8, 1}};
  for (const ScoreKind kind : {ScoreKind::kL1, ScoreKind::kCosine}) {
    EXPECT_NEAR(Similarity(kind, weights_, a, a), 1.0, 1e-12);
    EXPECT_EQ(Similarity(kind, weights_, a, b), 0.0);
    EXPECT_EQ(Similarity(kind, weights_, a, BowVector{}), 0.0);
  }
}

TEST(FixedLog, IsTheLogarithm) {
  EXPECT_EQ(FixedLog(0), 0);
  EXPECT_EQ(FixedLog(1), 0);
  EXPECT_NEAR(FixedLog(20000) / 4096.0, std::log(20000.0), 1.3e-4);
}

}  // namespace
}  // namespace deja_view::internal
