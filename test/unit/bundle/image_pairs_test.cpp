#include "image_pairs.hpp"

#include <algorithm>

#include "bundle_scene.hpp"
#include <gmock/gmock.h>

namespace deja_view::internal {
namespace {

using ::testing::ElementsAre;
using Pairs = std::vector<std::pair<int, int>>;

/// Cameras along x, all looking along z.
BundleProblem Row(const std::vector<double>& x) {
  BundleProblem problem;
  problem.cameras.push_back({std::make_shared<PinholeCamera>(test::BundleLens()), {}, 0.0});
  for (const double at : x) {
    problem.images.emplace_back().T_W_B.t.x() = at;
  }
  return problem;
}

TEST(ChooseImagePairs, TakesNeighboursAndLoops) {
  BundleOptions options;
  options.neighbours = 1;
  options.overlapping = 0;
  BundleProblem problem = Row({0, 10, 20, 30});
  problem.loops.push_back({3, 0, {}});
  EXPECT_EQ(ChooseImagePairs(options, problem), (Pairs{{0, 1}, {0, 3}, {1, 2}, {2, 3}}));
}

TEST(ChooseImagePairs, TakesImagesThatLookTheSameWayFromNearby) {
  BundleOptions options;
  options.neighbours = 0;
  options.overlapping = 5;
  options.reach_m = 2;
  BundleProblem problem = Row({0, 10, 1, 11, 0.5});
  problem.images[4].T_W_B.q = ExpSo3({0, 1.0, 0});  // looks elsewhere
  EXPECT_EQ(ChooseImagePairs(options, problem), (Pairs{{0, 2}, {1, 3}}));
}

TEST(ChooseImagePairs, SharesThePlacesBetweenTheVisits) {
  BundleOptions options;
  options.neighbours = 1;
  options.overlapping = 2;
  options.reach_m = 1;
  // Images 0 to 3 and 6 to 9 are near where image 10 is; 4 and 5 are away.
  const BundleProblem problem = Row({0, 0.1, 0.2, 0.3, 9, 9, 0.3, 0.2, 0.1, 0.05, 0});
  std::vector<int> partners;
  for (const auto& [a, b] : ChooseImagePairs(options, problem)) {
    if (b == 10) {
      partners.push_back(a);
    }
  }
  EXPECT_THAT(partners, ElementsAre(0, 8, 9));  // one of each visit and the neighbour
}

}  // namespace
}  // namespace deja_view::internal
