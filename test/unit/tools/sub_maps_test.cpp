#include "nerf/sub_maps.hpp"

#include "deja_view/base/check.hpp"

#include "temporary_directory.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

nerf::PosedImage At(double x) {
  nerf::PosedImage image;
  image.T_N_C.t = {x, 0, 0};
  return image;
}

/// Eight cameras on a line, x = 0 to 7: two of them held out, one only for its depth.
nerf::Split Line() {
  nerf::Split split;
  split.training = {At(1), At(2), At(3), At(5), At(6)};
  split.held_out = {At(0), At(4)};
  split.next = {0, 3};
  split.depth_checks = {At(7)};
  return split;
}

TEST(SubMaps, AreCutByAllCameras) {
  const nerf::Split split = Line();
  const SceneCells first = CutScene(split, "0/2");
  const SceneCells second = CutScene(split, "1/2");
  for (int x = 0; x < 8; ++x) {
    // Four of the eight on either side, which only the held-out ones at 0, 4 and 7 make so.
    EXPECT_NE(first.IsOwn(Eigen::Vector3d(x, 0, 0)), second.IsOwn(Eigen::Vector3d(x, 0, 0))) << x;
    EXPECT_EQ(first.IsOwn(Eigen::Vector3d(x, 0, 0)), first.IsOwn({0, 0, 0}) == (x < 4)) << x;
  }
}

TEST(SubMaps, AreNotCutWithoutShards) {
  EXPECT_FALSE(CutScene(Line(), "").IsCut());
  EXPECT_FALSE(CutScene(Line(), "0/1").IsCut());
  EXPECT_THROW(CutScene(Line(), "2/2"), InputError);
}

TEST(SubMaps, KeepTheirOwnHeldOutImages) {
  const SceneCells first = CutScene(Line(), "0/2");
  const bool is_left = first.IsOwn({0, 0, 0});
  nerf::Split split = Line();
  KeepOwnImages(first, &split);
  ASSERT_EQ(split.held_out.size(), 1U);
  EXPECT_EQ(split.held_out[0].T_N_C.t.x(), is_left ? 0 : 4);
  EXPECT_THAT(split.next, ElementsAre(is_left ? 0U : 3U));
  EXPECT_EQ(split.depth_checks.size(), is_left ? 0U : 1U);
  EXPECT_EQ(split.training.size(), 5U);
}

TEST(SubMaps, SayWhenTheyHaveNoHeldOutImage) {
  nerf::Split split = Line();
  split.held_out = {At(0), At(1)};
  split.next = {0, 1};
  const SceneCells cells = CutScene(Line(), "0/2");
  const bool is_left = cells.IsOwn({0, 0, 0});
  const SceneCells other = is_left ? CutScene(Line(), "1/2") : cells;
  EXPECT_THAT(MessageOf<InputError>([&] { KeepOwnImages(other, &split); }),
              HasSubstr("none of the 2 held-out images"));
}

TEST(SubMaps, AreTheModelsOwn) {
  const SceneCells cells = CutScene(Line(), "1/2");
  EXPECT_NO_THROW(CheckShard("", cells, "hall.dvn"));
  EXPECT_NO_THROW(CheckShard("1/2", cells, "hall.dvn"));
  EXPECT_THAT(MessageOf<InputError>([&] { CheckShard("0/2", cells, "hall.dvn"); }),
              HasSubstr("hall.dvn is the model of 1/2"));
}

}  // namespace
}  // namespace deja_view
