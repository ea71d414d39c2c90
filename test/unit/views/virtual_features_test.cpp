#include "deja_view/views/virtual_features.hpp"

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/features/orb_extractor.hpp"

#include "room_renderer.hpp"
#include "test_cameras.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

const PinholeCamera kPlainCamera = PinholeOf(320, 240, 200, 159.5, 119.5);

TEST(VirtualFeaturesTest, KeypointsKnowTheirDepth) {
  const RenderedView view = RoomRenderer(0.02).Render(kPlainCamera, {}, {});
  for (const std::string name : {"brief", "orb"}) {
    const std::unique_ptr<FeatureExtractor> extractor =
        name == "brief" ? std::unique_ptr<FeatureExtractor>(std::make_unique<BriefExtractor>())
                        : std::make_unique<OrbExtractor>();
    const VirtualFeatures features = ExtractVirtualFeatures(view, *extractor, {}, 0.5);
    EXPECT_EQ(features.descriptor, name);
    const Features direct = extractor->Extract(view.image);
    EXPECT_EQ(features.features.descriptors, direct.descriptors);
    ASSERT_GT(direct.keypoints.size(), 50U);
    ASSERT_EQ(features.depth_m.size(), direct.keypoints.size());
    for (std::size_t i = 0; i < direct.keypoints.size(); ++i) {
      const Keypoint& keypoint = features.features.keypoints[i];
      const Eigen::Vector3d ray = kPlainCamera.Unproject({keypoint.x, keypoint.y});
      const double range = RoomRenderer::Range({0, 0, 0}, ray);
      EXPECT_NEAR(features.depth_m[i], range, 0.02 * range);
      EXPECT_NEAR(features.depth_sigma_m[i], 0.02 * range, 0.005 * range);
    }
  }
}

TEST(VirtualFeaturesTest, ADepthEdgeMakesDepthUncertain) {
  RenderedView view = RoomRenderer(0.0).Render(kPlainCamera, {}, {});
  view.depth(cv::Rect(0, 0, 160, 240)).setTo(1);
  view.depth(cv::Rect(160, 0, 160, 240)).setTo(3);
  const VirtualFeatures features = ExtractVirtualFeatures(view, BriefExtractor(), {}, 0.5);
  for (std::size_t i = 0; i < features.depth_m.size(); ++i) {
    const auto x = static_cast<int>(std::lround(features.features.keypoints[i].x));
    const bool is_beside = x == 159 || x == 160;
    if (is_beside) {
      EXPECT_GT(features.depth_sigma_m[i], 0.9F);  // 1, 1, 3 or 3, 3, 1 across
    } else {
      EXPECT_EQ(features.depth_sigma_m[i], 0.0F);
    }
  }
}

TEST(VirtualFeaturesTest, LeavesOutWhatIsNotThere) {
  RenderedView view = RoomRenderer().Render(kPlainCamera, {}, {});
  view.opacity(cv::Rect(0, 0, 160, 240)).setTo(0.3);
  view.depth(cv::Rect(160, 0, 160, 120)).setTo(0);
  const VirtualFeatures features = ExtractVirtualFeatures(view, BriefExtractor(), {}, 0.5);
  ASSERT_GT(features.depth_m.size(), 20U);
  int unknown = 0;
  for (std::size_t i = 0; i < features.depth_m.size(); ++i) {
    const Keypoint& keypoint = features.features.keypoints[i];
    EXPECT_GE(keypoint.x, 159.5F);
    if (keypoint.y < 119) {
      EXPECT_EQ(features.depth_m[i], 0.0F);
      EXPECT_EQ(features.depth_sigma_m[i], 0.0F);
      ++unknown;
    }
  }
  EXPECT_GT(unknown, 5);
}

}  // namespace
}  // namespace deja_view
