#include "deja_view/lab/evaluation/place_truth.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/evaluation/threshold_sweep.hpp"

#include <tuple>
#include <vector>

#include "temporary_directory.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

class PlaceTruthTest : public TemporaryDirectoryTest {
 protected:
  PlaceTruth Read(const std::string& text, std::size_t images) const {
    return ReadPlaceTruth(Write("truth.txt", text), images);
  }
};

TEST_F(PlaceTruthTest, MatrixAndRowsSayTheSame) {
  const PlaceTruth expected = {{}, {}, {0}, {0, 1}};
  EXPECT_EQ(Read("# truth\n1 0 1 0\n0 1 0 0\n1,0,0,0\r\n\n1\t1 0 1\n", 4), expected)
      << "the diagonal and what lies right of it say nothing";
  EXPECT_EQ(Read("3: 1 0 1 3\n2: 0\n0: 2\n", 4), expected);
  EXPECT_EQ(CountRevisits(expected), 2);
  EXPECT_TRUE(IsTrueMatch(expected, 3, 1));
  EXPECT_FALSE(IsTrueMatch(expected, 2, 1));
  EXPECT_FALSE(IsTrueMatch(expected, 1, -1));
}

TEST_F(PlaceTruthTest, BadFilesAreNamed) {
  ExpectErrors(
      [&](const std::string& text) { return MessageOf<InputError>([&] { Read(text, 2); }); },
      {{"0 0\n", "truth.txt: 1 rows, expected one for each of 2 images"},
       {"0 0\n1\n", "truth.txt: line 2: 1 numbers, expected one for each of 2 images"},
       {"0 0\n2 0\n", "line 2: 2: expected a whole number from 0 to 1"},
       {"0 0\n1.0 0\n", "line 2: 1.0: expected"},
       {"1: 2\n", "line 1: 2: expected a whole number from 0 to 1"},
       {"1: 0\n0 0\n", "line 2: expected \"image: image image"},
       {"", "0 rows"},
       {"MATLAB 5.0 MAT-file\n", "scipy.io.loadmat"}});
  EXPECT_THAT(MessageOf<InputError>([&] { ReadPlaceTruth(directory_ / "none.txt", 2); }),
              Says("none.txt"));
}

TEST_F(PlaceTruthTest, CurveByHand) {
  // Images 2, 3, 4 show places again; 2 is found right, 3 wrongly, 4 right, 1 wrongly.
  const PlaceTruth truth = Read("2: 0\n3: 0\n4: 1\n", 5);
  std::vector<ScoredDecision> decisions;
  for (const auto& [query, match, score] :
       std::vector<std::tuple<int, int, double>>{{1, 0, 12}, {2, 0, 40}, {3, 1, 20}, {4, 1, 30}}) {
    const bool is_revisit = !truth[static_cast<std::size_t>(query)].empty();
    decisions.push_back({score, IsTrueMatch(truth, query, match), is_revisit});
  }
  const auto curve = SweepThreshold(decisions, CountRevisits(truth));
  ASSERT_EQ(curve.size(), 4U);
  EXPECT_EQ(curve[1].precision, 1.0);
  EXPECT_EQ(curve[1].recall, 2.0 / 3);
  EXPECT_EQ(curve[2].precision, 2.0 / 3);
  EXPECT_EQ(curve[3].precision, 0.5);
  EXPECT_EQ(PickThreshold(curve, 1.0).r, 30.0);
}

}  // namespace
}  // namespace deja_view
