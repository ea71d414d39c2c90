#include "deja_view/views/exposure_fit.hpp"

#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

struct Images {
  cv::Mat rendered = cv::Mat(60, 80, CV_8UC1);
  cv::Mat real = cv::Mat(60, 80, CV_8UC1);
  cv::Mat opacity = cv::Mat(60, 80, CV_32FC1, cv::Scalar(1));
};

Images MakeImages(double gain, double bias, double noise) {
  Images images;
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, noise);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      const int grey = 40 + 60 * (x / 16 % 2) + 40 * (y / 12 % 2) + static_cast<int>(random() % 30);
      images.rendered.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(grey);
      images.real.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(gain * grey + 255 * bias + normal(random));
    }
  }
  return images;
}

ExposureFit Fit(const Images& images) {
  return FitExposure(images.rendered, images.real, images.opacity, 0.5);
}

void ExpectFit(const Images& images, double gain, double bias, double tolerance) {
  const ExposureFit fit = Fit(images);
  EXPECT_NEAR(fit.gain, gain, tolerance);
  EXPECT_NEAR(fit.bias, bias, tolerance);
}

TEST(ExposureFitTest, FindsGainAndBias) {
  const Images images = MakeImages(1.3, -0.08, 2);
  const ExposureFit fit = Fit(images);
  EXPECT_NEAR(fit.gain, 1.3, 0.01);
  EXPECT_NEAR(fit.bias, -0.08, 0.005);
  EXPECT_GT(fit.correlation, 0.99);
  EXPECT_NEAR(fit.psnr_db, 20 * std::log10(255 / 2.0), 0.5);
}

TEST(ExposureFitTest, IsNotLedAstrayByAFewWrongPixels) {
  Images images = MakeImages(1, 0, 2);
  images.real(cv::Rect(0, 0, 80, 6)).setTo(255);
  ExpectFit(images, 1, 0, 0.015);
}

TEST(ExposureFitTest, PassesOverWhatIsNotOpaque) {
  Images images = MakeImages(0.7, 0.1, 1);
  images.real(cv::Rect(0, 0, 80, 40)).setTo(0);
  images.opacity(cv::Rect(0, 0, 80, 40)).setTo(0.4);
  ExpectFit(images, 0.7, 0.1, 0.01);
}

TEST(ExposureFitTest, ANegativeDoesNotCorrelate) {
  Images images = MakeImages(1, 0, 1);
  cv::bitwise_not(images.real, images.real);
  EXPECT_LT(Fit(images).correlation, 0.1);
}

TEST(ExposureFitTest, KeepsTheNeutralOneWhereThereIsNothingToFit) {
  Images images = MakeImages(1, 0, 1);
  images.opacity.setTo(0);
  const ExposureFit none = Fit(images);
  EXPECT_EQ(none.gain, 1);
  EXPECT_EQ(none.correlation, 0);
  images.opacity.setTo(1);
  images.real.setTo(100);
  EXPECT_EQ(Fit(images).gain, 1);
}

}  // namespace
}  // namespace deja_view
