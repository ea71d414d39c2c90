#include "deja_view/nerf/cell_images.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace deja_view::nerf {
namespace {

// Cameras every metre along x from 0 to 19, all of which look along +x or -x (or, at 90 deg, +z).
std::vector<PosedImage> Corridor(double yaw_deg) {
  const auto camera =
      std::make_shared<PinholeCamera>(PinholeParameters{320, 240, 200, 200, 159.5, 119.5});
  std::vector<PosedImage> images;
  for (int x = 0; x < 20; ++x) {
    PosedImage image;
    image.name = std::to_string(x);
    image.camera = camera;
    image.T_N_C = {ExpSo3({0, (90 - yaw_deg) * M_PI / 180, 0}), {1.0 * x, 0.1 * (x % 2), 0}};
    images.push_back(image);
  }
  return images;
}

SceneCell FirstHalf() {
  SceneCell cell;
  cell.max.x() = 9.5;
  return cell;
}

std::vector<std::string> Names(const std::vector<PosedImage>& images) {
  std::vector<std::string> names;
  for (const PosedImage& image : images) {
    names.push_back(image.name);
  }
  return names;
}

TEST(CellImagesTest, TakesTheCellsOwnCamerasAndThoseRightBesideIt) {
  // They look away from the cell: of the others only what is within 0.05 x 19 m of its cameras.
  const std::vector<PosedImage> selected = SelectCellImages(Corridor(0), FirstHalf());
  ASSERT_EQ(selected.size(), 10U);
  EXPECT_EQ(selected.back().name, "9");
  EXPECT_EQ(SelectCellImages(Corridor(0), FirstHalf(), {0.12, 0.5}).back().name, "11");
}

TEST(CellImagesTest, TakesImagesThatLookIntoTheCellFromNear) {
  const std::vector<PosedImage> selected = SelectCellImages(Corridor(180), FirstHalf());
  ASSERT_GT(selected.size(), 10U);
  EXPECT_LT(selected.size(), 20U);  // from far off it is small
  for (std::size_t i = 0; i < selected.size(); ++i) {
    EXPECT_EQ(selected[i].name, std::to_string(i));
  }
  const std::vector<PosedImage> all = SelectCellImages(Corridor(180), FirstHalf(), {0.05, 1e-3});
  EXPECT_GT(all.size(), selected.size());
}

TEST(CellImagesTest, WhatAWallHidesIsNotSeenInto) {
  std::vector<PosedImage> images = Corridor(180);
  for (PosedImage& image : images) {
    image.points = {{10, 10, 0.03F}, {20, 10, 0.02F}, {30, 10, 50}};
  }
  EXPECT_EQ(Names(SelectCellImages(images, FirstHalf())),
            Names(SelectCellImages(Corridor(0), FirstHalf())));
}

TEST(CellImagesTest, NothingForACellWithoutCameras) {
  SceneCell cell;
  cell.min.x() = 50;
  EXPECT_TRUE(SelectCellImages(Corridor(180), cell).empty());
}

}  // namespace
}  // namespace deja_view::nerf
