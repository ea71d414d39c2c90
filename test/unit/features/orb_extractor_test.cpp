#include "deja_view/features/orb_extractor.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/make_feature_extractor.hpp"

#include <cmath>
#include <cstring>
#include <set>

#include "synthetic_image.hpp"
#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

constexpr float kDegrees = static_cast<float>(180.0 / CV_PI);

Descriptor FromRow(const cv::Mat& rows, int i) {
  Descriptor descriptor;
  std::memcpy(descriptor.words.data(), rows.ptr(i), sizeof(Descriptor));
  return descriptor;
}

// The whole of cv::ORB on the full image, given our corners in its coordinates.
TEST(OrbExtractor, DescriptorsAreOpenCvs) {
  const cv::Mat image = test::SyntheticImage(752, 480, 1);
  OrbOptions options;
  options.levels = 8;
  const Features features = OrbExtractor(options).Extract(image);
  EXPECT_GT(features.keypoints.size(), 900U);
  std::vector<cv::KeyPoint> keypoints;
  std::set<int> octaves;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const Keypoint& k = features.keypoints[i];
    const float scale = static_cast<float>(std::pow(static_cast<double>(1.2F), k.octave));
    const auto to_level = [&](float full, int size) {
      const float ratio =
          static_cast<float>(size) / static_cast<float>(cvRound(static_cast<float>(size) / scale));
      return std::round((full + 0.5F) / ratio - 0.5F) * scale;
    };
    keypoints.emplace_back(to_level(k.x, image.cols),
                           to_level(k.y, image.rows),
                           31.0F,
                           k.angle * kDegrees,
                           k.response,
                           k.octave,
                           static_cast<int>(i));
    octaves.insert(k.octave);
  }
  EXPECT_EQ(octaves.size(), 8U);
  cv::Mat rows;
  const std::size_t count = keypoints.size();
  cv::ORB::create(1000, 1.2F, 8, 19, 0, 2, cv::ORB::HARRIS_SCORE, 31)
      ->compute(image, keypoints, rows);
  ASSERT_EQ(keypoints.size(), count);
  std::size_t differing = 0;
  for (int i = 0; i < rows.rows; ++i) {
    differing += FromRow(rows, i) != features.descriptors.at(keypoints[i].class_id) ? 1 : 0;
  }
  EXPECT_EQ(differing, 0U);
}

TEST(OrbExtractor, AnglesAreOpenCvs) {
  const cv::Mat image = test::SyntheticImage(320, 240, 5);
  std::vector<cv::KeyPoint> keypoints;
  cv::ORB::create(300, 1.2F, 1, 31, 0, 2, cv::ORB::FAST_SCORE, 31)->detect(image, keypoints);
  ASSERT_GT(keypoints.size(), 50U);
  for (const cv::KeyPoint& keypoint : keypoints) {
    EXPECT_EQ(internal::IntensityCentroidAngle(image, keypoint.pt), keypoint.angle);
  }
}

TEST(OrbExtractor, DescribesPointsEverywhere) {
  const cv::Mat image = test::SyntheticImage(320, 240, 2);
  std::vector<cv::KeyPoint> inner;
  std::vector<cv::Point2f> points = {{0, 0}, {319, 239}, {-50, 1000}, {1e9F, 3}, {NAN, INFINITY}};
  const std::size_t outer = points.size();
  for (int i = 0; i < 40; ++i) {
    const cv::Point pixel(30 + 6 * i, 30 + 4 * i);
    inner.emplace_back(pixel, 31.0F, internal::IntensityCentroidAngle(image, pixel));
    points.emplace_back(static_cast<float>(pixel.x) + 0.4F, static_cast<float>(pixel.y) - 0.4F);
  }
  std::vector<Descriptor> descriptors;
  OrbExtractor().Extract(image, {}, points, &descriptors);
  ASSERT_EQ(descriptors.size(), points.size());
  cv::Mat rows;
  cv::ORB::create(1000, 1.2F, 1, 19, 0, 2, cv::ORB::HARRIS_SCORE, 31)->compute(image, inner, rows);
  for (std::size_t i = 0; i < inner.size(); ++i) {
    EXPECT_EQ(descriptors[outer + i], FromRow(rows, static_cast<int>(i)));
  }
  EXPECT_EQ(descriptors[0], descriptors[4]);
  EXPECT_NE(descriptors[0], descriptors[1]);
}

TEST(OrbExtractor, EqualThresholdsGiveOpenCvsCorners) {
  const cv::Mat image = test::SyntheticImage(320, 240, 3);
  OrbOptions options;
  options.quadtree = QuadtreeMode::kCount;
  options.levels = 1;
  options.max_features = 100000;
  options.min_fast_threshold = options.fast_threshold;
  std::vector<cv::KeyPoint> all;
  cv::FAST(image, all, options.fast_threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  std::set<std::pair<int, int>> expected;
  for (const cv::KeyPoint& corner : all) {
    const int x = static_cast<int>(corner.pt.x);
    const int y = static_cast<int>(corner.pt.y);
    if (x >= 19 && y >= 19 && x < 320 - 19 && y < 240 - 19) {
      expected.emplace(x, y);
    }
  }
  const auto corners = [&] {
    std::set<std::pair<int, int>> found;
    for (const Keypoint& k : OrbExtractor(options).Extract(image).keypoints) {
      found.emplace(std::lround(k.x), std::lround(k.y));
    }
    return found;
  };
  EXPECT_GT(expected.size(), 50U);
  EXPECT_EQ(corners(), expected);
  // A lower second threshold adds corners only where there was none.
  options.min_fast_threshold = 7;
  const auto more = corners();
  for (const auto& corner : expected) {
    EXPECT_EQ(more.count(corner), 1U);
  }
}

TEST(OrbExtractor, EveryModeKeepsItsLimitAndSpreads) {
  const cv::Mat image = test::SyntheticImage(752, 480, 4);
  for (const QuadtreeMode mode :
       {QuadtreeMode::kCount, QuadtreeMode::kStd, QuadtreeMode::kAdaptiveFast}) {
    OrbOptions options;
    options.quadtree = mode;
    options.levels = 8;
    options.max_features = 500;
    const Features features = OrbExtractor(options).Extract(image);
    EXPECT_EQ(features.keypoints.size(), features.descriptors.size());
    EXPECT_LE(features.keypoints.size(), 500U) << EnumToString(mode);
    EXPECT_GE(features.keypoints.size(), 300U) << EnumToString(mode);
    std::set<int> cells;
    for (const Keypoint& k : features.keypoints) {
      EXPECT_GE(k.angle, 0.0F);
      EXPECT_LT(k.angle, 6.2832F);
      cells.insert(static_cast<int>(k.y) / 96 * 100 + static_cast<int>(k.x) / 94);
    }
    EXPECT_GE(cells.size(), 30U) << EnumToString(mode);  // of 40
  }
}

TEST(OrbExtractor, IsDeterministicAndTakesSmallImages) {
  const cv::Mat image = test::SyntheticImage(320, 240, 6);
  const OrbExtractor extractor;
  EXPECT_EQ(extractor.Extract(image).descriptors, extractor.Extract(image).descriptors);
  std::vector<Descriptor> descriptors;
  EXPECT_TRUE(extractor.Extract(cv::Mat(3, 3, CV_8UC1, cv::Scalar(9)), {}, {{1, 1}}, &descriptors)
                  .keypoints.empty());
  EXPECT_EQ(descriptors.size(), 1U);
  EXPECT_TRUE(extractor.Extract(cv::Mat(480, 752, CV_8UC1, cv::Scalar(9))).keypoints.empty());
}

TEST(OrbExtractor, RefusesWrongImagesAndOptions) {
  EXPECT_THROW(OrbExtractor().Extract(cv::Mat(100, 100, CV_8UC3)), CheckError);
  EXPECT_THROW(OrbExtractor().Extract(cv::Mat()), CheckError);
  OrbOptions options;
  options.levels = 0;
  options.min_fast_threshold = 30;
  EXPECT_EQ(options.Validate().size(), 2U);
  EXPECT_THROW(OrbExtractor{options}, CheckError);
}

TEST(MakeFeatureExtractor, MakesTheChosenKind) {
  FeatureOptions options;
  EXPECT_EQ(MakeFeatureExtractor(options)->DescriptorName(), "brief");
  options.kind = FeatureKind::kOrb;
  EXPECT_EQ(MakeFeatureExtractor(options)->DescriptorName(), "orb");
  options.orb.levels = 0;
  EXPECT_EQ(options.Validate().at(0), "orb.levels: 0, expected 1 to 16");
  EXPECT_THROW(MakeFeatureExtractor(options), CheckError);
}

}  // namespace
}  // namespace deja_view
