#include "deja_view/features/vertical_field.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/features/orb_extractor.hpp"

#include <cmath>

#include "synthetic_image.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

constexpr int kSizePx = 240;
constexpr double kFocalPx = 200.0;

PinholeCamera SquareCamera() {
  constexpr double kCentre = 0.5 * (kSizePx - 1);
  return PinholeCamera({kSizePx, kSizePx, kFocalPx, kFocalPx, kCentre, kCentre, 0, 0, 0, 0});
}

/// Down, in a camera that looks along the horizon and is turned clockwise about its axis.
Eigen::Vector3d DownAfterRoll(double angle) {
  return {std::sin(angle), std::cos(angle), 0.0};
}

TEST(VerticalField, ALevelCameraSeesVerticalsUpright) {
  const VerticalField field(SquareCamera(), {0, 2, 0});
  ASSERT_FALSE(field.empty());
  for (const float x : {0.0F, 60.0F, 239.0F}) {
    EXPECT_NEAR(field.Angle(x, 17.0F), 0.0, 1e-6);
  }
}

TEST(VerticalField, ARolledCameraSeesThemTurnedTheOtherWay) {
  const VerticalField field(SquareCamera(), DownAfterRoll(30 * kDegree));
  EXPECT_NEAR(field.Angle(30, 200), -30 * kDegree, 1e-6);
}

// Verticals meet where the camera would look straight down: (0, f / tan(pitch)) from the centre.
TEST(VerticalField, APitchedCameraSeesThemMeetBelow) {
  const double pitch = 40 * kDegree;
  const VerticalField field(SquareCamera(), {0, std::cos(pitch), std::sin(pitch)});
  const double nadir_y = 119.5 + kFocalPx / std::tan(pitch);
  for (const float x : {7.5F, 119.5F, 215.5F}) {
    // A cell's angle is that of its centre.
    const double cell_x = 16 * std::floor((x + 0.5) / 16) + 7.5;
    EXPECT_NEAR(field.Angle(x, 55.5F), std::atan2(cell_x - 119.5, nadir_y - 55.5), 1e-5) << x;
  }
}

TEST(VerticalField, ACameraThatLooksDownHasNone) {
  const VerticalField field(SquareCamera(), {0.1, 0, 1});
  EXPECT_TRUE(field.empty());
  EXPECT_EQ(field.Angle(10, 10), 0.0F);
  EXPECT_TRUE(VerticalField(SquareCamera(), {0.1, 0, -1}).empty());
  EXPECT_FALSE(VerticalField(SquareCamera(), {1, 0, 1}).empty());
}

TEST(VerticalField, KnowsAnyPixel) {
  const double pitch = 30 * kDegree;
  const VerticalField field(SquareCamera(), {0, std::cos(pitch), std::sin(pitch)});
  EXPECT_EQ(field.Angle(-1e9F, 0), field.Angle(0, 0));
  EXPECT_EQ(field.Angle(1e9F, 300), field.Angle(239, 239));
  EXPECT_EQ(field.Angle(NAN, INFINITY), field.Angle(0, 239));
}

TEST(VerticalField, IsMadeOnlyWhereItIsAskedFor) {
  // Looks north: right is east, down is -z of the world.
  Eigen::Matrix3d R_W_C;
  R_W_C << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond q_W_C = Eigen::Quaterniond(R_W_C) * roll;
  FeatureOptions options;
  EXPECT_NEAR(MakeVerticalField(options, SquareCamera(), q_W_C).Angle(99, 20), -0.3, 1e-6);
  options.orientation = PatchOrientation::kImage;
  EXPECT_TRUE(MakeVerticalField(options, SquareCamera(), q_W_C).empty());
}

TEST(VerticalField, StepsGoAllTheWayRound) {
  EXPECT_EQ(VerticalField::NearestStep(0), 0U);
  EXPECT_EQ(VerticalField::NearestStep(static_cast<float>(M_PI_2)), 16U);
  EXPECT_EQ(VerticalField::NearestStep(static_cast<float>(-M_PI_2)), 48U);
  EXPECT_EQ(VerticalField::NearestStep(static_cast<float>(M_PI)), 32U);
  EXPECT_EQ(VerticalField::NearestStep(-0.01F), 0U);
}

/// An image, the same turned a quarter clockwise, and points in both.
struct QuarterTurn {
  QuarterTurn() {
    cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
    for (const cv::Point2f& p : points) {
      turned_points.emplace_back(kSizePx - 1 - p.y, p.x);
    }
  }
  cv::Mat image = test::SyntheticImage(kSizePx, kSizePx, 4);
  cv::Mat turned;
  std::vector<cv::Point2f> points = {{60, 70}, {120, 40}, {199, 180}, {31, 140}};
  std::vector<cv::Point2f> turned_points;
};

// A camera that is rolled a quarter counterclockwise sees the world turned clockwise.
TEST(VerticalField, BriefOfARolledCameraIsThatOfALevelOne) {
  const QuarterTurn scene;
  const BriefExtractor extractor;
  std::vector<Descriptor> level;
  std::vector<Descriptor> rolled;
  std::vector<Descriptor> plain;
  extractor.Extract(scene.image, {SquareCamera(), {0, 1, 0}}, scene.points, &level);
  const Features features =
      extractor.Extract(scene.turned, {SquareCamera(), {-1, 0, 0}}, scene.turned_points, &rolled);
  extractor.Extract(scene.turned, {}, scene.turned_points, &plain);
  EXPECT_EQ(level, rolled);
  EXPECT_NE(level, plain);
  ASSERT_FALSE(features.keypoints.empty());
  EXPECT_NEAR(features.keypoints.front().angle, M_PI_2, 1e-6);
}

TEST(VerticalField, OrbIsTurnedByItAndNotByItsPatch) {
  const QuarterTurn scene;
  const Features features = OrbExtractor().Extract(scene.turned, {SquareCamera(), {-1, 0, 0}});
  ASSERT_FALSE(features.keypoints.empty());
  for (const Keypoint& keypoint : features.keypoints) {
    EXPECT_NEAR(keypoint.angle, M_PI_2, 1e-5);
  }
}

}  // namespace
}  // namespace deja_view
