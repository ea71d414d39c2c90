#include "deja_view/nerf/image_metrics.hpp"

#include <cmath>
#include <memory>
#include <random>

#include "test_cameras.hpp"
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace deja_view::nerf {
namespace {

cv::Mat RandomBlocks(unsigned seed) {
  std::mt19937 rng(seed);
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(100));
  for (int i = 0; i < 300; ++i) {
    const cv::Rect block(static_cast<int>(rng() % 300),
                         static_cast<int>(rng() % 220),
                         4 + static_cast<int>(rng() % 16),
                         4 + static_cast<int>(rng() % 16));
    cv::rectangle(image, block, cv::Scalar(static_cast<double>(rng() % 256)), cv::FILLED);
  }
  return image;
}

TEST(ImageMetrics, PsnrOfAKnownError) {
  const cv::Mat a(20, 30, CV_8UC1, cv::Scalar(100));
  EXPECT_NEAR(Psnr(a, a + 5), 20 * std::log10(255.0 / 5), 1e-9);
  EXPECT_EQ(Psnr(a, a), 99.0);
}

TEST(ImageMetrics, SsimIsOneForEqualImagesAndFallsWithBlur) {
  const cv::Mat a = RandomBlocks(1);
  cv::Mat weak;
  cv::Mat strong;
  cv::GaussianBlur(a, weak, {}, 0.7);
  cv::GaussianBlur(a, strong, {}, 3);
  EXPECT_NEAR(Ssim(a, a), 1, 1e-6);
  EXPECT_LT(Ssim(a, weak), 1);
  EXPECT_LT(Ssim(a, strong), Ssim(a, weak));
}

TEST(ImageMetrics, SsimOfFlatImagesIsTheLuminanceTerm) {
  const cv::Mat a(20, 30, CV_8UC1, cv::Scalar(100));
  const cv::Mat b(20, 30, CV_8UC1, cv::Scalar(150));
  constexpr double kC1 = 2.55 * 2.55;
  EXPECT_NEAR(Ssim(a, b), (2 * 100 * 150 + kC1) / (100.0 * 100 + 150 * 150 + kC1), 1e-3);
}

TEST(ImageMetrics, CornersMatchTheSameImageButNotAnotherOrAShiftedOne) {
  const cv::Mat a = RandomBlocks(1);
  EXPECT_GT(CornerMatchRate(a, a), 0.99);
  EXPECT_LT(CornerMatchRate(a, RandomBlocks(2)), 0.1);
  cv::Mat shifted;
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, 10, 0, 1, 0);
  cv::warpAffine(a, shifted, shift, a.size());
  EXPECT_LT(CornerMatchRate(a, shifted), 0.1);
}

TEST(WarpImage, ShiftsAWallByItsParallax) {
  TrainingView from;
  from.camera = SharedPinholeOf(60, 40, 50, 29.5, 19.5);
  from.image.create(40, 60, CV_8UC1);
  cv::randu(from.image, 1, 255);
  // 0.1 m to the left of a wall 1 m away: what is at x here is at x + 5 there.
  from.T_N_C.t = {-0.1, 0, 0};
  cv::Mat depth(40, 60, CV_32FC1);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      depth.at<float>(y, x) = static_cast<float>(1 / from.camera->Unproject({x, y}).z());
    }
  }
  depth.at<float>(3, 3) = 0;
  const cv::Mat warped = WarpImage(from, *from.camera, Rigid3::Identity(), depth);
  EXPECT_EQ(warped.at<std::uint8_t>(20, 30), from.image.at<std::uint8_t>(20, 35));
  EXPECT_EQ(warped.at<std::uint8_t>(7, 11), from.image.at<std::uint8_t>(7, 16));
  EXPECT_EQ(warped.at<std::uint8_t>(20, 58), 0);
  EXPECT_EQ(warped.at<std::uint8_t>(3, 3), 0);
}

}  // namespace
}  // namespace deja_view::nerf
