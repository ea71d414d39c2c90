#include "own_points.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include <memory>
#include <vector>

#include "test_cameras.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

PinholeCamera TestCamera() {
  return PinholeOf(640, 480, 500, 320, 240);
}

KeyframeFeatures OneTrackedPoint() {
  KeyframeFeatures f;
  f.T_B_C.t = {0.1, 0, 0};
  f.points_B = {{0.1F, 0, 3}};
  f.point_pixels = {{320, 240}};
  f.point_depth_sigmas = {0.1F};
  f.point_ids = {42};
  f.point_descriptors.resize(1);
  return f;
}

TEST(ReplaceOwnPointsTest, PutsCornersBehindTheTrackedPoints) {
  const PinholeCamera camera = TestCamera();
  CornerView view = MakeCornerView({{420, 240}}, std::vector<Descriptor>(1), camera);
  view.descriptors[0].words[0] = 5;
  view.depths = {{0.5F, 0.01F, 2}};
  KeyframeFeatures f = OneTrackedPoint();
  for (int i = 0; i < 2; ++i) {  // the second time in the place of the first
    ReplaceOwnPoints(view, camera, {}, &f);
    ASSERT_THAT(f.point_ids, testing::ElementsAre(42, kOwnPoint));
    const Eigen::Vector3f p_C = 2.0F * Eigen::Vector3f(0.2F, 0, 1).normalized();
    EXPECT_LT((f.points_B[1] - p_C - Eigen::Vector3f(0.1F, 0, 0)).norm(), 1e-5F);
    EXPECT_EQ(f.point_pixels[1], Eigen::Vector2f(420, 240));
    EXPECT_FLOAT_EQ(f.point_depth_sigmas[1], 0.04F);  // 0.01 / 0.5^2
    EXPECT_EQ(f.point_descriptors[1], view.descriptors[0]);
  }
  MotionStereoOptions content;
  content.enough = 1;
  KeyframeFeatures rich = OneTrackedPoint();
  ReplaceOwnPoints(view, camera, content, &rich);
  EXPECT_EQ(rich.points_B.size(), 1U) << "the VIO's are enough";
  view.depths[0] = {};
  ReplaceOwnPoints(view, camera, {}, &f);
  EXPECT_THAT(f.point_ids, testing::ElementsAre(42));
  EXPECT_EQ(f.points_B.size(), 1U);
}

TEST(MedianDepthTest, IsOfTheDistancesFromTheCamera) {
  KeyframeFeatures f;
  f.T_B_C.t = {0, 0, 1};
  EXPECT_EQ(MedianDepth(f), 4.0);  // of nothing
  for (int i = 1; i <= 11; ++i) {
    f.points_B.emplace_back(0, 0, 1.0F + static_cast<float>(i));
  }
  EXPECT_DOUBLE_EQ(MedianDepth(f), 6.0);
}

}  // namespace
}  // namespace deja_view
