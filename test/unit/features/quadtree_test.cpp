#include "quadtree.hpp"

#include <random>

#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

std::vector<cv::KeyPoint> RandomCorners(int count, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> x(0, 751);
  std::uniform_int_distribution<int> y(0, 479);
  std::uniform_int_distribution<int> response(7, 100);
  std::vector<cv::KeyPoint> corners;
  for (int i = 0; i < count; ++i) {
    corners.emplace_back(cv::Point(x(rng), y(rng)), 7.0F, -1.0F, static_cast<float>(response(rng)));
  }
  return corners;
}

TEST(Quadtree, KeepsTheStrongestOfEachQuarter) {
  std::vector<cv::KeyPoint> corners = RandomCorners(400, 1);
  const auto kept = SelectByQuadtree(corners, {0, 0, 752, 480}, 4);
  ASSERT_EQ(kept.size(), 4U);
  for (int quarter = 0; quarter < 4; ++quarter) {
    const cv::Rect2f region(376.0F * static_cast<float>(quarter % 2),
                            240.0F * static_cast<float>(quarter / 2),
                            376.0F,
                            240.0F);
    float strongest = 0;
    int inside = 0;
    for (const cv::KeyPoint& corner : corners) {
      strongest = region.contains(corner.pt) ? std::max(strongest, corner.response) : strongest;
    }
    for (const cv::KeyPoint& corner : kept) {
      if (region.contains(corner.pt)) {
        ++inside;
        EXPECT_EQ(corner.response, strongest);
      }
    }
    EXPECT_EQ(inside, 1);
  }
}

TEST(Quadtree, ReachesTheTargetWhateverTheOrder) {
  std::vector<cv::KeyPoint> corners = RandomCorners(3000, 2);
  const auto kept = SelectByQuadtree(corners, {0, 0, 752, 480}, 217);
  EXPECT_EQ(kept.size(), 217U);
  std::shuffle(corners.begin(), corners.end(), std::mt19937(3));
  const auto again = SelectByQuadtree(corners, {0, 0, 752, 480}, 217);
  ASSERT_EQ(again.size(), kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(again[i].pt, kept[i].pt);
  }
}

TEST(Quadtree, TakesAllOfFewAndNoneOfNone) {
  EXPECT_TRUE(SelectByQuadtree({}, {0, 0, 752, 480}, 100).empty());
  EXPECT_TRUE(SelectByQuadtree(RandomCorners(10, 4), {0, 0, 752, 480}, 0).empty());
  std::vector<cv::KeyPoint> corners = {
      {cv::Point(1, 1), 7, -1, 5}, {cv::Point(2, 1), 7, -1, 6}, {cv::Point(700, 400), 7, -1, 7}};
  EXPECT_EQ(SelectByQuadtree(corners, {0, 0, 752, 480}, 100).size(), 3U);
  EXPECT_EQ(SelectByQuadtree(corners, {0, 0, 100, 100}, 100).size(), 2U);
  corners.push_back(corners[0]);  // one position twice can't be parted
  EXPECT_EQ(SelectByQuadtree(corners, {0, 0, 752, 480}, 100).size(), 3U);
}

}  // namespace
}  // namespace deja_view::internal
