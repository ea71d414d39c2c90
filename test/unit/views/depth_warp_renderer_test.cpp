#include "deja_view/views/depth_warp_renderer.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>

#include "room_renderer.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

const auto kCamera = std::make_shared<PinholeCamera>(
    PinholeParameters{320, 240, 200, 200, 159.5, 119.5, -0.1, 0.01, 0, 0});

DepthWarpRenderer MakeWarp(const Rigid3& T_N_C) {
  const RenderedView real = RoomRenderer().Render(*kCamera, T_N_C, {});
  return {real.image, {real.depth, real.depth_variance}, kCamera, T_N_C};
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::mean(difference, mask)[0];
}

TEST(DepthWarpRendererTest, ShowsTheImageItselfAtItsOwnPose) {
  const RenderedView real = RoomRenderer().Render(*kCamera, {}, {});
  const RenderedView view = MakeWarp({}).Render(*kCamera, {}, {});
  const cv::Rect inner(1, 1, 318, 238);
  EXPECT_LE(cv::norm(view.image(inner), real.image(inner), cv::NORM_INF), 1);
  EXPECT_LE(cv::norm(view.depth(inner), real.depth(inner), cv::NORM_INF), 0.02);
  EXPECT_EQ(cv::countNonZero(view.opacity(inner) < 1), 0);
}

TEST(DepthWarpRendererTest, SeesWhatACameraBesideItWould) {
  const Rigid3 T_N_C{ExpSo3({0.1, 0.3, 0}), {0.5, 0.2, -0.3}};
  const Rigid3 T_N_V = T_N_C * Rigid3{ExpSo3({0.02, -0.05, 0.03}), {0.15, -0.1, 0.2}};
  const RenderedView truth = RoomRenderer().Render(*kCamera, T_N_V, {});
  const RenderedView view = MakeWarp(T_N_C).Render(*kCamera, T_N_V, {});
  const cv::Mat is_known = view.opacity > 0.5;
  EXPECT_GT(cv::countNonZero(is_known), 320 * 240 * 8 / 10);
  EXPECT_LT(MeanDifference(view.image, truth.image, is_known), 4);
  EXPECT_LT(cv::mean(cv::abs(view.depth - truth.depth), is_known)[0], 0.02);
  // The unmoved image is far from it.
  const RenderedView unmoved = RoomRenderer().Render(*kCamera, T_N_C, {});
  EXPECT_GT(MeanDifference(unmoved.image, truth.image, is_known), 15);
}

TEST(DepthWarpRendererTest, WhatTheImageDoesNotShowIsAHole) {
  const Rigid3 turned{ExpSo3({0, 0.5, 0}), {0, 0, 0}};  // to the right
  const RenderedView view = MakeWarp({}).Render(*kCamera, turned, {});
  EXPECT_EQ(view.opacity.at<float>(120, 310), 0.0F);
  EXPECT_EQ(view.depth.at<float>(120, 310), 0.0F);
  EXPECT_EQ(view.opacity.at<float>(120, 20), 1.0F);
  // Filled from its border.
  EXPECT_EQ(view.image.at<std::uint8_t>(120, 310), view.image.at<std::uint8_t>(120, 319));
  const RenderedView behind = MakeWarp({}).Render(*kCamera, {ExpSo3({0, M_PI, 0}), {0, 0, 0}}, {});
  EXPECT_EQ(cv::countNonZero(behind.opacity), 0);
}

TEST(DepthWarpRendererTest, NearThingsHideFarOnes) {
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(50));
  RangeMap ranges{cv::Mat(240, 320, CV_32FC1, cv::Scalar(4)), cv::Mat::zeros(240, 320, CV_32FC1)};
  const cv::Rect box(140, 100, 40, 40);
  image(box).setTo(200);
  ranges.range_m(box).setTo(1);
  const DepthWarpRenderer warp(image, ranges, kCamera, {});
  const RenderedView view =
      warp.Render(*kCamera, {Eigen::Quaterniond::Identity(), {0.3, 0, 0}}, {});
  // 60 px to the left, over what is 15 px to the left; a hole where it was, beside the background.
  EXPECT_EQ(view.image.at<std::uint8_t>(120, 100), 200);
  EXPECT_NEAR(view.depth.at<float>(120, 100), 1, 0.1);
  EXPECT_EQ(view.opacity.at<float>(120, 140), 0.0F);
  EXPECT_EQ(view.image.at<std::uint8_t>(120, 200), 50);
}

TEST(DepthWarpRendererTest, AppliesTheExposure) {
  const RenderedView view = MakeWarp({}).Render(*kCamera, {}, {0.5F, 0.1F, 1});
  const RenderedView real = RoomRenderer().Render(*kCamera, {}, {});
  EXPECT_NEAR(view.image.at<std::uint8_t>(100, 100),
              0.5 * real.image.at<std::uint8_t>(100, 100) + 25.5,
              1.0);
}

TEST(DensifyRangesTest, InterpolatesBetweenSamples) {
  std::vector<RangeSample> samples;
  const auto wall = [](double x) { return 2 + x / 160; };
  for (int y = 10; y < 240; y += 20) {
    for (int x = 10; x < 320; x += 20) {
      samples.push_back({{x, y}, wall(x)});
    }
  }
  const RangeMap map = DensifyRanges(samples, {320, 240});
  for (int x = 20; x < 300; x += 7) {
    EXPECT_NEAR(map.range_m.at<float>(100, x), wall(x), 0.08);
    EXPECT_GT(map.variance.at<float>(100, x), 0.0F);
    EXPECT_LT(map.variance.at<float>(100, x), 0.2F);
  }
}

TEST(DensifyRangesTest, KnowsNothingWithoutSamples) {
  const RangeMap map = DensifyRanges({{{5, 5}, -1}, {{5, 5}, NAN}}, {64, 48});
  EXPECT_EQ(cv::countNonZero(map.range_m), 0);
  const RangeMap one = DensifyRanges({{{5, 5}, 2.5}}, {64, 48});
  EXPECT_NEAR(one.range_m.at<float>(40, 60), 2.5, 1e-5);
}

}  // namespace
}  // namespace deja_view
