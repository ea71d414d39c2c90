#include "deja_view/triangulation/motion_stereo.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/features/brief_extractor.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include "room_renderer.hpp"
#include "test_cameras.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

std::shared_ptr<const Camera> RoomCamera() {
  return SharedPinholeOf(376, 240, 229, 187, 119);
}

/// Flies through the room of RoomRenderer with a real extractor.
class MotionStereoTest : public testing::Test {
 protected:
  /// Camera at `position`, looking along x and turned by `yaw_deg`.
  static Rigid3 Pose(const Eigen::Vector3d& position, double yaw_deg) {
    Eigen::Matrix3d R_W_C;
    R_W_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return {FromYaw(ToRadians(yaw_deg)) * Eigen::Quaterniond(R_W_C), position};
  }
  std::vector<const MotionStereo::Image*> Add(int id,
                                              const Rigid3& T_W_C,
                                              std::size_t tracked = 0) {
    const Features features = extractor_.Extract(room_.Render(*camera_, T_W_C, {}).image);
    std::vector<Eigen::Vector2f> pixels;
    for (const Keypoint& keypoint : features.keypoints) {
      pixels.emplace_back(keypoint.x, keypoint.y);
    }
    return stereo_.Add(
        id, T_W_C, MakeCornerView(pixels, features.descriptors, *camera_), tracked, 3.0);
  }
  int CountCertain(const MotionStereo::Image& image) const {
    int certain = 0;
    for (const InverseDepth& depth : image.view.depths) {
      certain += IsCertain(depth, options_.pair) ? 1 : 0;
    }
    return certain;
  }
  /// Share of the certain corners whose depth is wrong by more than three deviations.
  double ShareWrong(const MotionStereo::Image& image) const {
    int wrong = 0;
    for (std::size_t i = 0; i < image.view.depths.size(); ++i) {
      const InverseDepth& depth = image.view.depths[i];
      const Eigen::Vector3d ray = image.T_W_C.q * image.view.rays[i].cast<double>();
      const double truth = RoomRenderer::Range(image.T_W_C.t, ray);
      wrong += IsCertain(depth, options_.pair) &&
                       std::abs(depth.mean - 1 / truth) > 3 * static_cast<double>(depth.sigma)
                   ? 1
                   : 0;
    }
    return static_cast<double>(wrong) / std::max(1, CountCertain(image));
  }

  static MotionStereoOptions TenRecent() {
    MotionStereoOptions options;
    options.recent = 10;
    return options;
  }
  MotionStereoOptions options_ = TenRecent();
  std::shared_ptr<const Camera> camera_ = RoomCamera();
  RoomRenderer room_;
  BriefExtractor extractor_;
  MotionStereo stereo_{options_, camera_};
};

TEST_F(MotionStereoTest, CornersOfAFlightGetTheirDepths) {
  std::vector<const MotionStereo::Image*> images;
  for (int i = 0; i < 6; ++i) {
    images = Add(i, Pose({0.02 * i, 0.12 * i, 0}, 3.0 * i));
  }
  ASSERT_EQ(images.front()->id, 5);
  EXPECT_GT(CountCertain(*images.front()), 80);
  EXPECT_LT(ShareWrong(*images.front()), 0.05);
}

TEST_F(MotionStereoTest, AnImageLearnsFromThoseAfterIt) {
  ASSERT_EQ(CountCertain(*Add(7, Pose({0, 0, 0}, 0)).front()), 0);
  const auto images = Add(8, Pose({0, 0.3, 0}, 5));
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[1]->id, 7);
  EXPECT_GT(CountCertain(*images[1]), 50);
  EXPECT_LT(ShareWrong(*images[1]), 0.05);
}

TEST_F(MotionStereoTest, TurningOnTheSpotTellsNothing) {
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(CountCertain(*Add(i, Pose({0, 0, 0}, 5.0 * i)).front()), 0);
  }
}

TEST_F(MotionStereoTest, AnImageWithEnoughTrackedPointsIsNotMatchedButHelpsTheNext) {
  const auto enough = static_cast<std::size_t>(options_.enough);
  Add(0, Pose({0, 0, 0}, 0), enough);
  EXPECT_EQ(Add(1, Pose({0, 0.3, 0}, 5), enough).size(), 1U);
  EXPECT_GT(CountCertain(*Add(2, Pose({0, 0.5, 0}, 5), enough - 1).front()), 50);
}

TEST_F(MotionStereoTest, AnImageWithoutTrackedPointsLearnsFromThoseWithEnough) {
  const auto enough = static_cast<std::size_t>(options_.enough);
  Add(0, Pose({0, 0, 0}, 0), enough - 1);
  Add(1, Pose({0, 0.01, 0}, 0), enough);
  const auto images = Add(2, Pose({0, 0.3, 0}, 5), enough);
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[1]->id, 0);
  EXPECT_GT(CountCertain(*images[1]), 50);
  EXPECT_LT(ShareWrong(*images[1]), 0.05);
  for (int i = 1; i < options_.partners; ++i) {
    EXPECT_EQ(Add(2 + i, Pose({0, 0.3 + 0.05 * i, 0}, 5), enough).size(), 2U) << i;
  }
  EXPECT_EQ(Add(9, Pose({0, 0.5, 0}, 5), enough).size(), 1U) << "it has all its partners";
}

TEST_F(MotionStereoTest, ImagesThatShareNoViewAreNoPartners) {
  Add(0, Pose({0, 0, 0}, 0));
  EXPECT_EQ(Add(1, Pose({0, 0.3, 0}, 90)).size(), 1U);
}

TEST_F(MotionStereoTest, ImagesOfAnotherWorldAreForgotten) {
  Add(0, Pose({0, 0, 0}, 0));
  stereo_.Restart();
  EXPECT_EQ(Add(1, Pose({0, 0.3, 0}, 5)).size(), 1U);
}

TEST_F(MotionStereoTest, OnlyRecentImagesAreKept) {
  options_.recent = 2;
  stereo_ = MotionStereo(options_, camera_);
  Add(0, Pose({0, 0, 0}, 0));
  for (int i = 1; i < 4; ++i) {
    Add(i, Pose({0, 0.01 * i, 0}, 90));
  }
  EXPECT_EQ(Add(4, Pose({0, 0.3, 0}, 5)).size(), 1U);
}

TEST(SelectPointsTest, TakesTheBestOfTheCertainThatAreNoPointsYet) {
  const std::shared_ptr<const Camera> camera = RoomCamera();
  MotionStereoOptions options;
  CornerView view = MakeCornerView(
      {{50, 50}, {100, 50}, {150, 50}, {200, 50}, {250, 50}}, std::vector<Descriptor>(5), *camera);
  view.depths = {{0.5F, 0.02F, 1},   // certain
                 {0.5F, 0.02F, 2},   // better: two images say so
                 {0.5F, 0.2F, 3},    // not certain
                 {0.5F, 0.015F, 3},  // a point already
                 {0.5F, 0.015F, 1}};
  const std::vector<Eigen::Vector2f> taken = {{202, 51}};
  EXPECT_THAT(SelectPoints(view, taken, *camera, options), testing::ElementsAre(1, 4, 0));
  options.max_points = 2;
  EXPECT_THAT(SelectPoints(view, taken, *camera, options), testing::ElementsAre(1, 4));
  options.min_distance_px = 2;
  EXPECT_THAT(SelectPoints(view, taken, *camera, options), testing::ElementsAre(3, 1));
}

TEST(MotionStereoOptionsTest, ViolationsAreListed) {
  MotionStereoOptions options;
  EXPECT_TRUE(options.Validate().empty());
  options.partners = 0;
  options.pair.pixel_sigma = 0;
  EXPECT_EQ(options.Validate().size(), 2U);
}

}  // namespace
}  // namespace deja_view
