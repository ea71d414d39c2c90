#include "point_selection.hpp"

#include <algorithm>
#include <numeric>

#include "bundle_scene.hpp"
#include <gmock/gmock.h>

namespace deja_view::internal {
namespace {

/// Three images; `counts[n]` points in n images each, all over the image.
BundleProblem Points(const std::vector<int>& counts) {
  Random random(3);
  BundleProblem problem;
  problem.cameras.push_back({std::make_shared<PinholeCamera>(test::BundleLens()), {}, 0.0});
  problem.images.resize(3);
  for (std::size_t views = 0; views < counts.size(); ++views) {
    for (int i = 0; i < counts[views]; ++i) {
      BundlePoint& point = problem.points.emplace_back();
      for (std::size_t image = 0; image < views; ++image) {
        auto& keypoints = problem.images[image].keypoints;
        keypoints.emplace_back(random.UniformFloat() * 640, random.UniformFloat() * 480);
        point.observations.push_back(
            {static_cast<int>(image), static_cast<int>(keypoints.size()) - 1});
      }
    }
  }
  return problem;
}

TEST(SelectPoints, TakesAllWhereThereAreFewOrAllAreWanted) {
  const BundleProblem problem = Points({0, 0, 5, 10});
  std::vector<int> all(15);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(SelectPoints(problem, 100), all);
  EXPECT_EQ(SelectPoints(problem, 0), all);
}

TEST(SelectPoints, PrefersPointsThatManyImagesSee) {
  const BundleProblem problem = Points({0, 0, 500, 500});
  const std::vector<int> selected = SelectPoints(problem, 96);
  EXPECT_GE(selected.size(), 96U);
  EXPECT_LT(selected.size(), 200U);
  const auto seen_by_three = std::count_if(selected.begin(), selected.end(), [&](int point) {
    return problem.points[static_cast<std::size_t>(point)].observations.size() == 3;
  });
  EXPECT_GT(static_cast<double>(seen_by_three), 0.9 * static_cast<double>(selected.size()));
}

}  // namespace
}  // namespace deja_view::internal
