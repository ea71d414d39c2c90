#include "deja_view/features/brief_extractor.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "synthetic_image.hpp"
#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

// The definition, one sample at a time.
Descriptor ReferenceBrief(const cv::Mat& smooth, int x, int y, const BriefPattern& pattern) {
  const auto sample = [&](int u, int v) {
    return smooth.at<std::uint8_t>(std::min(std::max(v, 0), smooth.rows - 1),
                                   std::min(std::max(u, 0), smooth.cols - 1));
  };
  Descriptor descriptor;
  for (int i = 0; i < 256; ++i) {
    const BriefPattern::Pair& p = pattern.pairs[i];
    if (sample(x + p.x1, y + p.y1) < sample(x + p.x2, y + p.y2)) {
      descriptor.words[i / 64] |= std::uint64_t{1} << (i % 64);
    }
  }
  return descriptor;
}

cv::Mat Smooth(const cv::Mat& image) {
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {9, 9}, 2, 2);
  return smooth;
}

TEST(BriefExtractor, DescriptorsAreBitExact) {
  const cv::Mat image = test::SyntheticImage(752, 480, 1);
  const Features features = BriefExtractor().Extract(image);
  ASSERT_EQ(features.keypoints.size(), 1000U);
  ASSERT_EQ(features.descriptors.size(), 1000U);
  const cv::Mat smooth = Smooth(image);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    ASSERT_EQ(features.descriptors[i],
              ReferenceBrief(smooth,
                             static_cast<int>(keypoint.x),
                             static_cast<int>(keypoint.y),
                             DefaultBriefPattern()));
  }
}

TEST(BriefExtractor, WorksOnAPartOfALargerImage) {
  const cv::Mat image = test::SyntheticImage(752, 480, 1);
  const cv::Rect part(31, 57, 400, 300);
  const Features of_view = BriefExtractor().Extract(image(part));
  const Features of_copy = BriefExtractor().Extract(image(part).clone());
  ASSERT_EQ(of_view.keypoints.size(), of_copy.keypoints.size());
  EXPECT_EQ(of_view.descriptors, of_copy.descriptors);
}

TEST(BriefExtractor, DescribesPointsAtAndBeyondTheBorder) {
  const cv::Mat image = test::SyntheticImage(320, 240, 2);
  const std::vector<cv::Point2f> points = {{0, 0},
                                           {319, 239},
                                           {160.4F, 120.6F},
                                           {23.4F, 24.5F},
                                           {-50, 1000},
                                           {1e9F, -1e9F},
                                           {100.5F, 0.49F},
                                           {295, 215.49F},
                                           {NAN, INFINITY}};
  std::vector<Descriptor> descriptors(3);
  BriefExtractor().Extract(image, {}, points, &descriptors);
  ASSERT_EQ(descriptors.size(), points.size());
  const cv::Mat smooth = Smooth(image);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const int x = static_cast<int>(std::lround(std::clamp(points[i].x, -5000.0F, 5000.0F)));
    const int y = static_cast<int>(std::lround(std::clamp(points[i].y, -5000.0F, 5000.0F)));
    EXPECT_EQ(descriptors[i], ReferenceBrief(smooth, x, y, DefaultBriefPattern())) << i;
  }
}

TEST(BriefExtractor, TruncatesPointsWhenAsked) {
  const cv::Mat image = test::SyntheticImage(320, 240, 2);
  BriefOptions options;
  options.point_rounding = PixelRounding::kTruncate;
  std::vector<Descriptor> descriptors;
  BriefExtractor(options).Extract(image, {}, {{160.9F, 120.9F}}, &descriptors);
  EXPECT_EQ(descriptors[0], ReferenceBrief(Smooth(image), 160, 120, DefaultBriefPattern()));
}

TEST(BriefExtractor, KeepsOnlyDescribableCorners) {
  const cv::Mat image = test::SyntheticImage(320, 240, 3);
  BriefOptions options;
  options.max_features = 100000;
  const Features features = BriefExtractor(options).Extract(image);
  std::vector<cv::KeyPoint> all;
  cv::FAST(image, all, options.fast_threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  const int radius = DefaultBriefPattern().Radius();
  std::set<std::pair<int, int>> expected;
  for (const cv::KeyPoint& corner : all) {
    const int x = static_cast<int>(corner.pt.x);
    const int y = static_cast<int>(corner.pt.y);
    if (x >= radius && y >= radius && x + radius < 320 && y + radius < 240) {
      expected.emplace(x, y);
    }
  }
  std::set<std::pair<int, int>> found;
  for (const Keypoint& keypoint : features.keypoints) {
    found.emplace(static_cast<int>(keypoint.x), static_cast<int>(keypoint.y));
  }
  EXPECT_GT(found.size(), 50U);
  EXPECT_EQ(found, expected);
}

TEST(BriefExtractor, SpreadsCornersOverTheImage) {
  const cv::Mat image = test::SyntheticImage(752, 480, 4);
  BriefOptions spread;
  spread.max_features = 300;
  BriefOptions strongest = spread;
  strongest.cell_size_px = 0;
  const auto occupied = [&](const BriefOptions& options) {
    std::set<int> cells;
    for (const Keypoint& k : BriefExtractor(options).Extract(image).keypoints) {
      cells.insert(static_cast<int>(k.y) / 48 * 100 + static_cast<int>(k.x) / 48);
    }
    return cells.size();
  };
  EXPECT_GT(occupied(spread), occupied(strongest));
}

TEST(BriefExtractor, TinyAndFlatImagesHaveNoCorners) {
  EXPECT_TRUE(BriefExtractor().Extract(cv::Mat(5, 5, CV_8UC1, cv::Scalar(9))).keypoints.empty());
  EXPECT_TRUE(
      BriefExtractor().Extract(cv::Mat(480, 752, CV_8UC1, cv::Scalar(9))).keypoints.empty());
}

TEST(BriefExtractor, RefusesWrongImagesAndOptions) {
  EXPECT_THROW(BriefExtractor().Extract(cv::Mat(100, 100, CV_8UC3)), CheckError);
  EXPECT_THROW(BriefExtractor().Extract(cv::Mat()), CheckError);
  BriefOptions options;
  options.max_features = 0;
  options.smoothing_kernel_px = 4;
  EXPECT_EQ(options.Validate().size(), 2U);
  EXPECT_THROW(BriefExtractor{options}, CheckError);
}

}  // namespace
}  // namespace deja_view
