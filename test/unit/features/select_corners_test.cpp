#include "select_corners.hpp"

#include <map>
#include <random>

#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

// Nine in ten corners crowd in one cell.
std::vector<cv::KeyPoint> Crowded(unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<cv::KeyPoint> corners;
  for (int i = 0; i < 1000; ++i) {
    const int range = i % 10 == 0 ? 480 : 48;
    const cv::Point p(static_cast<int>(rng() % range), static_cast<int>(rng() % range));
    corners.emplace_back(p, 7.0F, -1.0F, static_cast<float>(i % 10 == 0 ? 20 : 50 + rng() % 50));
  }
  return corners;
}

TEST(SelectCorners, StrongestIgnoresWhereCornersAre) {
  std::vector<cv::KeyPoint> corners = Crowded(1);
  KeepStrongest(200, &corners);
  ASSERT_EQ(corners.size(), 200U);
  for (const cv::KeyPoint& corner : corners) {
    EXPECT_GE(corner.response, 50.0F);
  }
}

TEST(SelectCorners, SpreadGivesEveryCellItsShare) {
  std::vector<cv::KeyPoint> corners = Crowded(1);
  std::map<int, int> available;
  const auto cell_of = [](const cv::KeyPoint& k) {
    return static_cast<int>(k.pt.y) / 48 * 10 + static_cast<int>(k.pt.x) / 48;
  };
  for (const cv::KeyPoint& corner : corners) {
    ++available[cell_of(corner)];
  }
  KeepSpread(150, 48, &corners);
  ASSERT_EQ(corners.size(), 150U);
  std::map<int, int> kept;
  for (const cv::KeyPoint& corner : corners) {
    ++kept[cell_of(corner)];
  }
  // No cell that still had corners got two fewer than another.
  for (const auto& [cell, count] : available) {
    for (const auto& [other, other_count] : kept) {
      EXPECT_TRUE(kept[cell] == count || kept[cell] + 1 >= other_count) << cell << " " << other;
    }
  }
}

TEST(SelectCorners, FewCornersAreLeftAlone) {
  std::vector<cv::KeyPoint> corners = Crowded(2);
  const std::vector<cv::KeyPoint> before = corners;
  KeepSpread(1000, 48, &corners);
  KeepStrongest(1000, &corners);
  ASSERT_EQ(corners.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(corners[i].pt, before[i].pt);
  }
}

}  // namespace
}  // namespace deja_view::internal
