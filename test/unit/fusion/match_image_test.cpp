#include "deja_view/fusion/match_image.hpp"

#include "test_cameras.hpp"
#include "wall_flight.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

class MatchImagesTest : public ::testing::Test {
 protected:
  MatchImagesTest() : current_(flight_.Keyframe(3, 10)), old_(flight_.Keyframe(2, 10)) {
    relocalisation_.old = 5;
    for (int i = 0; i < 10; ++i) {
      const TrackedPoint& point = current_.points[static_cast<std::size_t>(i)];
      relocalisation_.points.push_back({point.feature_id, {0.02 * i, 0.01 * i}});
    }
    relocalisation_.points.push_back({-77, {0, 0}});  // of no tracked point
  }

  // With pictures of keyframes 5 and 9.
  MatchImages Images(int memory) const {
    MatchImages images(memory);
    images.Add(5, old_.image);
    images.Add(9, current_.image);
    return images;
  }

  test::WallFlight flight_;
  KeyframeInput current_;
  KeyframeInput old_;
  Relocalisation relocalisation_;
  PinholeCamera camera_ =
      PinholeOf(test::WallFlight::kWidth, test::WallFlight::kHeight, 230, 188, 120);
};

TEST_F(MatchImagesTest, ShowsBothKeyframesAndTheirMatches) {
  MatchImages images = Images(10);
  const auto picture = images.Draw(current_, 9, relocalisation_, camera_);
  ASSERT_TRUE(picture.has_value());
  EXPECT_EQ(picture->type(), CV_8UC3);
  EXPECT_EQ(picture->size(), cv::Size(test::WallFlight::kWidth, test::WallFlight::kHeight / 2));
  const cv::Vec3b pixel = picture->at<cv::Vec3b>(60, 94);  // the first match's old end, in colour
  EXPECT_NE(pixel[0], pixel[2]);
}

TEST_F(MatchImagesTest, ForgetsTheOldest) {
  MatchImages images = Images(2);
  images.Add(10, current_.image);
  EXPECT_FALSE(images.Draw(current_, 9, relocalisation_, camera_).has_value());
  relocalisation_.old = 9;
  EXPECT_TRUE(images.Draw(current_, 10, relocalisation_, camera_).has_value());
}

TEST_F(MatchImagesTest, AnotherMapMakesItForgetAll) {
  MatchImages images = Images(10);
  images.Add(3, current_.image);
  EXPECT_FALSE(images.Draw(current_, 9, relocalisation_, camera_).has_value());
}

TEST_F(MatchImagesTest, KeepsNothingWhenToldSo) {
  MatchImages images = Images(0);
  EXPECT_FALSE(images.Draw(current_, 9, relocalisation_, camera_).has_value());
}

}  // namespace
}  // namespace deja_view
