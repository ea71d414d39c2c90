#include "deja_view/nerf/occupancy_grid.hpp"

#include <algorithm>
#include <cstdlib>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace deja_view::nerf {
namespace {

TEST(OccupancyGrid, IndexAndCellAreInverse) {
  const OccupancyGrid grid(10, {1.0F, 0.5F, 0.71F});
  EXPECT_EQ(grid.cells(), (std::array<int, 3>{12, 8, 8}));
  EXPECT_EQ(grid.cell_count(), std::size_t{12 * 8 * 8});
  for (std::size_t i = 0; i < grid.cell_count(); ++i) {
    const auto [x, y, z] = grid.Cell(i);
    ASSERT_EQ(grid.Index(x, y, z), i);
  }
}

TEST(OccupancyGrid, SetsOneCell) {
  OccupancyGrid grid(8, {1, 1, 1});
  EXPECT_EQ(grid.CountOccupied(), std::size_t{512});
  const std::size_t index = grid.Index(5, 2, 7);
  grid.Set(index, false);
  EXPECT_FALSE(grid.IsOccupied(index));
  EXPECT_TRUE(grid.IsOccupied(grid.Index(5, 2, 6)));
  EXPECT_EQ(grid.CountOccupied(), std::size_t{511});
  grid.Set(index, true);
  EXPECT_TRUE(grid.IsOccupied(index));
}

TEST(OccupancyGrid, LeapsEndAtTheNearestMatter) {
  OccupancyGrid grid(72, {1.0F, 0.8F, 0.6F});
  std::vector<std::uint64_t> words(grid.words().size(), 0);
  std::mt19937 rng(5);
  for (int i = 0; i < 6; ++i) {
    words[rng() % words.size()] = 1;
  }
  grid.SetWords(words);
  for (std::size_t a = 0; a < words.size(); ++a) {
    int nearest = 15;
    for (std::size_t b = 0; b < words.size(); ++b) {
      if (words[b] == 0) {
        continue;
      }
      const auto at = grid.Cell(64 * a);
      const auto matter = grid.Cell(64 * b);
      int apart = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        apart = std::max(apart, std::abs(at[axis] - matter[axis]) / 4);
      }
      nearest = std::min(nearest, apart);
    }
    ASSERT_EQ(grid.leap(a), nearest) << a;
  }
}

}  // namespace
}  // namespace deja_view::nerf
