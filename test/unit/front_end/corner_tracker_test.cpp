#include "deja_view/front_end/corner_tracker.hpp"

#include <algorithm>
#include <map>

#include "synthetic_image.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr int kViewWidth = 320;
constexpr int kViewHeight = 240;

class CornerTrackerTest : public ::testing::Test {
 protected:
  /// What a camera sees that has moved `x` pixels to the right.
  cv::Mat View(int x) const { return wall_(cv::Rect(x, 0, kViewWidth, kViewHeight)).clone(); }

  cv::Mat wall_ = test::SyntheticImage(3 * kViewWidth, kViewHeight, 5);
};

std::map<std::int64_t, cv::Point2f> ById(const TrackedCorners& corners) {
  std::map<std::int64_t, cv::Point2f> pixels;
  for (std::size_t i = 0; i < corners.ids.size(); ++i) {
    pixels[corners.ids[i]] = corners.pixels[i];
  }
  return pixels;
}

TEST_F(CornerTrackerTest, FollowsCornersThatKeepTheirIds) {
  CornerTracker tracker({});
  const auto before = ById(tracker.Add(View(0)));
  ASSERT_GT(before.size(), 60U);
  const auto after = ById(tracker.Add(View(7)));
  std::size_t common = 0;
  for (const auto& [id, pixel] : after) {
    if (before.count(id) > 0) {
      ++common;
      EXPECT_NEAR(pixel.x, before.at(id).x - 7, 0.2);
      EXPECT_NEAR(pixel.y, before.at(id).y, 0.2);
    }
  }
  EXPECT_GT(common, 0.8 * static_cast<double>(before.size()));
}

TEST_F(CornerTrackerTest, KeepsItsDistanceAndItsNumber) {
  CornerTrackerOptions options;
  options.max_corners = 40;
  CornerTracker tracker(options);
  for (int x = 0; x < 300; x += 10) {
    const TrackedCorners corners = tracker.Add(View(x));
    ASSERT_LE(corners.ids.size(), 40U);
    ASSERT_GE(corners.ids.size(), 20U);
    EXPECT_TRUE(std::is_sorted(corners.ids.begin(), corners.ids.end()));
  }
}

TEST_F(CornerTrackerTest, LosesWhatIsNotThereAnyMore) {
  CornerTracker tracker({});
  const auto before = ById(tracker.Add(View(0)));
  const auto after = ById(tracker.Add(View(2 * kViewWidth)));
  std::size_t common = 0;
  for (const auto& entry : after) {
    common += before.count(entry.first);
  }
  EXPECT_LT(common, before.size() / 5);
}

TEST_F(CornerTrackerTest, FindsItsCornersInASecondCamerasImage) {
  CornerTracker tracker({});
  EXPECT_TRUE(tracker.FindIn(View(0)).empty());
  const TrackedCorners corners = tracker.Add(View(100));
  const auto found = tracker.FindIn(View(130));
  ASSERT_EQ(found.size(), corners.ids.size());
  std::size_t right = 0;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const cv::Point2f expected = corners.pixels[i] - cv::Point2f(30, 0);
    if (found[i]) {
      ++(cv::norm(*found[i] - expected) < 0.5 ? right : wrong);
    }
  }
  EXPECT_GT(right, found.size() / 2);
  EXPECT_LT(wrong, found.size() / 20);  // look alike by chance
  const auto elsewhere = tracker.FindIn(View(2 * kViewWidth));
  EXPECT_LT(std::count_if(elsewhere.begin(), elsewhere.end(), [](const auto& p) { return p; }),
            static_cast<std::ptrdiff_t>(found.size() / 5));
}

TEST_F(CornerTrackerTest, StartsAnewWithIdsThatGoOn) {
  CornerTracker tracker({});
  const std::int64_t last = tracker.Add(View(0)).ids.back();
  tracker.Restart();
  EXPECT_GT(tracker.Add(View(0)).ids.front(), last);
}

TEST_F(CornerTrackerTest, FindsNothingOnABlankWall) {
  CornerTracker tracker({});
  EXPECT_TRUE(tracker.Add(cv::Mat(kViewHeight, kViewWidth, CV_8UC1, cv::Scalar(90))).ids.empty());
}

}  // namespace
}  // namespace deja_view
