#include "deja_view/views/depth_warp_model.hpp"

#include "room_renderer.hpp"
#include "test_cameras.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

const auto kFlatCamera = SharedPinholeOf(160, 120, 100, 79.5, 59.5);

TEST(DepthWarpModelTest, WarpsByTheRangesThatAreKnownOrElseByThePoints) {
  const RenderedView real = RoomRenderer().Render(*kFlatCamera, {}, {});
  const DepthWarpModel model(
      kFlatCamera,
      [&](std::int64_t stamp_ns) {
        return stamp_ns == 1 ? std::optional(RangeMap{real.depth, real.depth_variance})
                             : std::nullopt;
      },
      "maps of a room\n");
  EXPECT_FALSE(model.NeedsPoints());
  EXPECT_EQ(model.Describe(), "maps of a room\n");
  const std::vector<RangeSample> points = {{{80, 60}, 9.0}};
  const auto middle = [&](std::int64_t stamp_ns) {
    return model.RendererFor({stamp_ns, real.image, {}}, points)
        ->Render(*kFlatCamera, {}, {})
        .depth.at<float>(60, 80);
  };
  EXPECT_NEAR(middle(1), real.depth.at<float>(60, 80), 0.02);
  EXPECT_NEAR(middle(2), 9, 1e-3);
}

TEST(DepthWarpModelTest, WithoutRangesItNeedsPoints) {
  EXPECT_TRUE(DepthWarpModel(kFlatCamera, nullptr, "").NeedsPoints());
}

TEST(DepthWarpModelTest, LiesInTheFrameOfItsImages) {
  const Similarity3 W_N =
      DepthWarpModel(kFlatCamera, nullptr, "").FindFrame(Similarity3{3, {FromYaw(1), {1, 2, 3}}});
  EXPECT_EQ(W_N.scale, 1);
  EXPECT_TRUE(W_N.T_A_B.t.isZero(0));
}

TEST(DepthWarpModelTest, AsksLessOfTheViewsThanAFieldWould) {
  GateOptions gate;
  gate.free_space = true;
  gate.max_depth_sigma = 0.05;
  gate.min_certain_share = 0.9;
  DepthWarpModel(kFlatCamera, nullptr, "").Relax(&gate);
  EXPECT_FALSE(gate.free_space);
  EXPECT_EQ(gate.max_depth_sigma, 0.3);
  EXPECT_EQ(gate.min_certain_share, 0.5);
}

}  // namespace
}  // namespace deja_view
