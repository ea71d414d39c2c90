#include "deja_view/nerf/occupancy_grid.hpp"

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

}  // namespace
}  // namespace deja_view::nerf
