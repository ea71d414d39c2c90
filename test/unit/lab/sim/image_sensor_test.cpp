#include "deja_view/lab/sim/image_sensor.hpp"

#include <cmath>

#include "small_world.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view::sim {
namespace {

cv::Mat Flat(double radiance) {
  return {TinyCamera()->height(), TinyCamera()->width(), CV_32FC1, cv::Scalar(radiance)};
}

SensorOptions Ideal() {
  SensorOptions options;
  options.noise = 0;
  options.vignetting = 0;
  return options;
}

TEST(ImageSensor, ExposesToTheTargetLevel) {
  ImageSensor sensor(Ideal(), *TinyCamera(), 1);
  const cv::Mat image = sensor.Expose(Flat(0.4));
  const double expected = 255 * std::pow(Ideal().target_level, 1 / Ideal().gamma);
  EXPECT_NEAR(cv::mean(image)[0], expected, 1.0);
}

TEST(ImageSensor, AdaptsSlowlyOrNotAtAll) {
  SensorOptions options = Ideal();
  ImageSensor adapting(options, *TinyCamera(), 1);
  options.auto_exposure = false;
  ImageSensor fixed(options, *TinyCamera(), 1);
  const double normal = cv::mean(adapting.Expose(Flat(0.4)))[0];
  fixed.Expose(Flat(0.4));
  const double first_gain = fixed.gain();
  EXPECT_GT(cv::mean(adapting.Expose(Flat(0.8)))[0], 1.2 * normal);
  for (int i = 0; i < 60; ++i) {
    adapting.Expose(Flat(0.8));
    fixed.Expose(Flat(0.8));
  }
  EXPECT_NEAR(cv::mean(adapting.Expose(Flat(0.8)))[0], normal, 1.0);
  EXPECT_EQ(fixed.gain(), first_gain);
}

TEST(ImageSensor, VignettingDarkensTheCorners) {
  SensorOptions options = Ideal();
  options.vignetting = 0.5;
  ImageSensor sensor(options, *TinyCamera(), 1);
  const cv::Mat image = sensor.Expose(Flat(0.4));
  EXPECT_LT(image.at<std::uint8_t>(0, 0),
            0.8 * image.at<std::uint8_t>(image.rows / 2, image.cols / 2));
}

TEST(ImageSensor, NoiseHasTheAskedSizeAndIsNewInEveryImage) {
  SensorOptions options = Ideal();
  options.noise = 3.0;
  ImageSensor sensor(options, *TinyCamera(), 1);
  const cv::Mat a = sensor.Expose(Flat(0.4));
  const cv::Mat b = sensor.Expose(Flat(0.4));
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(a, mean, deviation);
  const double expected = 3.0 * (1 + 1.2 * std::sqrt(options.target_level));
  EXPECT_NEAR(deviation[0], expected, 0.2);
  EXPECT_GT(cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total()), 2.0);
  ImageSensor again(options, *TinyCamera(), 1);
  EXPECT_EQ(cv::norm(a, again.Expose(Flat(0.4)), cv::NORM_INF), 0);
}

TEST(ImageSensor, BlackAndGlaringStayInRange) {
  ImageSensor sensor(SensorOptions(), *TinyCamera(), 1);
  EXPECT_LT(cv::mean(sensor.Expose(Flat(0)))[0], 5);
  cv::Mat window = Flat(0.3);
  window.rowRange(0, window.rows / 8).setTo(50.0);
  const cv::Mat image = ImageSensor(Ideal(), *TinyCamera(), 1).Expose(window);
  EXPECT_EQ(image.at<std::uint8_t>(1, image.cols / 2), 255);
  EXPECT_GT(image.at<std::uint8_t>(image.rows - 1, image.cols / 2), 40);
}

}  // namespace
}  // namespace deja_view::sim
