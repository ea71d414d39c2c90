#include "deja_view/bundle/bundle_features.hpp"

#include "deja_view/features/brief_extractor.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

/// A bright quadrant whose corner lies at `corner` [px], blurred as a lens does.
cv::Mat Quadrant(const Eigen::Vector2d& corner) {
  constexpr int kOversampling = 8;
  cv::Mat fine(120 * kOversampling, 160 * kOversampling, CV_8UC1, cv::Scalar(60));
  const cv::Point at(static_cast<int>(std::lround((corner.x() + 0.5) * kOversampling)),
                     static_cast<int>(std::lround((corner.y() + 0.5) * kOversampling)));
  fine(cv::Rect(at.x, at.y, fine.cols - at.x, fine.rows - at.y)).setTo(180);
  cv::Mat image;
  cv::resize(fine, image, {160, 120}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(image, image, {7, 7}, 1.0);
  return image;
}

Eigen::Vector2d Nearest(const BundleImage& image, const Eigen::Vector2d& to) {
  return std::min_element(image.keypoints.begin(),
                          image.keypoints.end(),
                          [&](const auto& a, const auto& b) {
                            return (a.template cast<double>() - to).norm() <
                                   (b.template cast<double>() - to).norm();
                          })
      ->cast<double>();
}

TEST(DescribeImage, FindsCornersToAFractionOfAPixel) {
  const BriefExtractor extractor;
  for (const double fraction : {0.0, 0.25, 0.5, 0.75}) {
    const Eigen::Vector2d corner(80 + fraction, 60 - fraction / 2);
    BundleImage image;
    DescribeImage(Quadrant(corner), {}, extractor, &image);
    ASSERT_FALSE(image.keypoints.empty());
    // A blurred corner looks a third of a pixel further in, whatever its fraction of a pixel.
    EXPECT_LT((Nearest(image, corner) - corner).norm(), 0.45) << fraction;
  }
}

TEST(DescribeImage, PutsTheViosPixelsFirstAndNoCornerBesideThem) {
  const BriefExtractor extractor;
  const cv::Mat grey = Quadrant({80, 60});
  BundleImage image;
  DescribeImage(grey, {{{79.25F, 61.5F}, 7}, {{20.5F, 20}, 8}}, extractor, &image);
  ASSERT_GE(image.keypoints.size(), 2U);
  EXPECT_EQ(image.keypoints[0], Eigen::Vector2f(79.25F, 61.5F));
  EXPECT_EQ(image.track_ids[0], 7);
  EXPECT_EQ(image.track_ids[1], 8);
  EXPECT_EQ(image.descriptors.size(), image.keypoints.size());
  EXPECT_EQ(image.track_ids.size(), image.keypoints.size());
  for (std::size_t i = 2; i < image.keypoints.size(); ++i) {
    EXPECT_GT((image.keypoints[i] - image.keypoints[0]).norm(), 2) << i;
    EXPECT_EQ(image.track_ids[i], -1);
  }
}

}  // namespace
}  // namespace deja_view
