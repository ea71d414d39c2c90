#include "deja_view/features/keypoint_grid.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

std::vector<int> Near(const KeypointGrid& grid, const Eigen::Vector2f& pixel, float radius) {
  std::vector<int> found;
  grid.ForEachNear(pixel, radius, [&](int i) { found.push_back(i); });
  return found;
}

TEST(KeypointGrid, FindsWhatBruteForceFinds) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> u(0.0F, 1.0F);
  std::vector<Eigen::Vector2f> keypoints;
  for (int i = 0; i < 700; ++i) {
    const float x = 751 * u(rng);
    keypoints.emplace_back(x, 479 * u(rng));
  }
  keypoints.emplace_back(0.0F, 0.0F);
  keypoints.emplace_back(751.0F, 479.0F);
  for (const float cell : {7.0F, 32.0F, 1000.0F}) {
    const KeypointGrid grid(keypoints, 752, 480, cell);
    for (int query = 0; query < 200; ++query) {
      const float x = -30 + 812 * u(rng);
      const Eigen::Vector2f pixel(x, -30 + 540 * u(rng));
      const float radius = 60 * u(rng);
      std::vector<int> expected;
      for (std::size_t i = 0; i < keypoints.size(); ++i) {
        if ((keypoints[i] - pixel).squaredNorm() <= radius * radius) {
          expected.push_back(static_cast<int>(i));
        }
      }
      std::vector<int> found = Near(grid, pixel, radius);
      EXPECT_EQ(found, Near(grid, pixel, radius)) << "another order the second time";
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(KeypointGrid, KeepsKeypointsOutsideTheImage) {
  const std::vector<Eigen::Vector2f> keypoints = {{-5, -5}, {110, 50}, {50, 90}};
  const KeypointGrid grid(keypoints, 100, 80, 32.0F);
  EXPECT_EQ(Near(grid, {-4, -4}, 3), std::vector<int>({0}));
  EXPECT_EQ(Near(grid, {108, 50}, 3), std::vector<int>({1}));
  EXPECT_EQ(Near(grid, {50, 88}, 3), std::vector<int>({2}));
}

TEST(KeypointGrid, IsEmptyWithoutKeypoints) {
  const std::vector<Eigen::Vector2f> none;
  EXPECT_TRUE(Near(KeypointGrid(none, 752, 480, 32.0F), {100, 100}, 1000).empty());
}

}  // namespace
}  // namespace deja_view
