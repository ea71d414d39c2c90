#include "deja_view/nerf/scene_cells.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace deja_view::nerf {
namespace {

using Positions = std::vector<Eigen::Vector3d>;

Positions RandomPositions(std::size_t count, const Eigen::Vector3d& extent) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  Positions positions;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = uniform(random);
    const double y = uniform(random);
    positions.push_back(extent.cwiseProduct(Eigen::Vector3d(x, y, uniform(random))));
  }
  return positions;
}

std::vector<std::size_t> CountPerCell(const std::vector<SceneCell>& cells, const Positions& all) {
  std::vector<std::size_t> counts;
  for (const SceneCell& cell : cells) {
    counts.push_back(static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [&](const auto& p) { return cell.Contains(p); })));
  }
  return counts;
}

TEST(SceneCellsTest, EveryCameraIsInOneCellAndAllHaveAboutAsMany) {
  const Positions positions = RandomPositions(997, {20, 15, 3});
  for (int count = 1; count <= 13; ++count) {
    const std::vector<SceneCell> cells = CutByCameras(positions, count);
    ASSERT_EQ(cells.size(), static_cast<std::size_t>(count));
    std::size_t sum = 0;
    for (const std::size_t own : CountPerCell(cells, positions)) {
      EXPECT_NEAR(static_cast<double>(own), 997.0 / count, 2) << count;
      sum += own;
    }
    EXPECT_EQ(sum, positions.size());
  }
}

TEST(SceneCellsTest, EveryPlaceIsInOneCell) {
  const std::vector<SceneCell> cells = CutByCameras(RandomPositions(100, {20, 15, 3}), 7);
  Positions places = RandomPositions(500, {60, 60, 60});
  for (Eigen::Vector3d& place : places) {
    place.array() -= 30;
  }
  // On the cuts themselves.
  for (const SceneCell& cell : cells) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (std::isfinite(cell.min[axis])) {
        places.emplace_back(1, 1, 1);
        places.back()[axis] = cell.min[axis];
      }
    }
  }
  for (const Eigen::Vector3d& place : places) {
    EXPECT_EQ(std::count_if(cells.begin(),
                            cells.end(),
                            [&](const SceneCell& cell) { return cell.Contains(place); }),
              1)
        << place.transpose();
  }
}

TEST(SceneCellsTest, CutsAcrossTheWidestAxisAtTheMedian) {
  const Positions positions = {{1, 0, 0}, {2, 9, 0}, {3, 0, 1}, {5, 30, 0}, {8, 31, 0}};
  const std::vector<SceneCell> cells = CutByCameras(positions, 2);
  EXPECT_EQ(cells[0].max.y(), 19.5);  // between 9 and 30: three below
  EXPECT_EQ(cells[1].min.y(), 19.5);
  EXPECT_TRUE(std::isinf(cells[0].max.x()) && std::isinf(cells[0].min.y()));
  EXPECT_EQ(CountPerCell(cells, positions), (std::vector<std::size_t>{3, 2}));
}

TEST(SceneCellsTest, TheOrderOfTheCamerasDoesNotMatter) {
  Positions positions = RandomPositions(200, {20, 15, 3});
  positions.insert(positions.end(), positions.begin(), positions.begin() + 20);  // hovering
  const std::vector<SceneCell> cells = CutByCameras(positions, 5);
  std::mt19937 random(3);
  for (int i = 0; i < 5; ++i) {
    std::shuffle(positions.begin(), positions.end(), random);
    EXPECT_TRUE(CutByCameras(positions, 5) == cells);
  }
}

TEST(SceneCellsTest, CamerasAtOnePlaceStayTogether) {
  Positions positions(10, Eigen::Vector3d(1, 2, 3));
  positions.insert(positions.end(), 2, {1, 2, 4});
  const std::vector<SceneCell> cells = CutByCameras(positions, 2);
  EXPECT_EQ(CountPerCell(cells, positions), (std::vector<std::size_t>{10, 2}));
  // Neighbours in floating point.
  positions = {{1, 0, 0}, {std::nextafter(1.0, 2.0), 0, 0}};
  EXPECT_EQ(CountPerCell(CutByCameras(positions, 2), positions), (std::vector<std::size_t>{1, 1}));
}

TEST(SceneCellsTest, AsManyCellsAsPlacesCanBeHad) {
  // The first cut, across y, leaves one place above it and three below.
  const Positions positions = {{0, 0, 0}, {2, 0, 0}, {3, 0, 0}, {2, 5, 0}, {2, 5, 0}, {2, 5, 0}};
  const std::vector<SceneCell> cells = CutByCameras(positions, 4);
  EXPECT_EQ(CountPerCell(cells, positions), (std::vector<std::size_t>{1, 1, 1, 3}));
}

TEST(SceneCellsTest, TooFewPlacesAreAnError) {
  EXPECT_THROW(CutByCameras({{0, 0, 0}, {0, 0, 0}, {0, 0, 1}}, 3), InputError);
  EXPECT_THROW(CutByCameras({}, 1), InputError);
  EXPECT_THROW(CutByCameras({{0, 0, 0}, {0, NAN, 1}}, 2), InputError);
}

TEST(SceneCellsTest, OneFieldForAllOwnsEveryPlace) {
  SceneCells cells;
  EXPECT_FALSE(cells.IsCut());
  EXPECT_TRUE(cells.IsOwn({1e9, 0, 0}));
  EXPECT_EQ(cells.shard(), (Shard{0, 1}));
  cells.cells = CutByCameras({{0, 0, 0}, {2, 0, 0}}, 2);
  cells.index = 1;
  EXPECT_EQ(cells.shard(), (Shard{1, 2}));
  EXPECT_TRUE(cells.IsOwn({1, 0, 0}));
  EXPECT_FALSE(cells.IsOwn({0.9, 0, 0}));
}

}  // namespace
}  // namespace deja_view::nerf
