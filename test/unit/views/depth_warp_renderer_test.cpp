#include "deja_view/views/depth_warp_renderer.hpp"

#include <cmath>

#include "room_renderer.hpp"
#include "test_cameras.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

DepthWarpRenderer MakeWarp(const Rigid3& T_N_C) {
  const RenderedView real = RoomRenderer().Render(*BentCamera(), T_N_C, {});
  return {real.image, {real.depth, real.depth_variance}, BentCamera(), T_N_C};
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::mean(difference, mask)[0];
}

TEST(DepthWarpRendererTest, ShowsTheImageItselfAtItsOwnPose) {
  const RenderedView real = RoomRenderer().Render(*BentCamera(), {}, {});
  const RenderedView view = MakeWarp({}).Render(*BentCamera(), {}, {});
  const cv::Rect inner(1, 1, 318, 238);
  EXPECT_LE(cv::norm(view.image(inner), real.image(inner), cv::NORM_INF), 1);
  EXPECT_LE(cv::norm(view.depth(inner), real.depth(inner), cv::NORM_INF), 0.02);
  EXPECT_EQ(cv::countNonZero(view.opacity(inner) < 1), 0);
}

TEST(DepthWarpRendererTest, SeesWhatACameraBesideItWould) {
  const Rigid3 T_N_C{ExpSo3({0.1, 0.3, 0}), {0.5, 0.2, -0.3}};
  const Rigid3 T_N_V = T_N_C * Rigid3{ExpSo3({0.02, -0.05, 0.03}), {0.15, -0.1, 0.2}};
  const RenderedView truth = RoomRenderer().Render(*BentCamera(), T_N_V, {});
  const RenderedView view = MakeWarp(T_N_C).Render(*BentCamera(), T_N_V, {});
  const cv::Mat is_known = view.opacity > 0.5;
  EXPECT_GT(cv::countNonZero(is_known), 320 * 240 * 8 / 10);
  EXPECT_LT(MeanDifference(view.image, truth.image, is_known), 4);
  EXPECT_LT(cv::mean(cv::abs(view.depth - truth.depth), is_known)[0], 0.02);
  // The unmoved image is far from it.
  const RenderedView unmoved = RoomRenderer().Render(*BentCamera(), T_N_C, {});
  EXPECT_GT(MeanDifference(unmoved.image, truth.image, is_known), 15);
}

TEST(DepthWarpRendererTest, WhatTheImageDoesNotShowIsAHole) {
  const Rigid3 turned{ExpSo3({0, 0.5, 0}), {0, 0, 0}};  // to the right
  const RenderedView view = MakeWarp({}).Render(*BentCamera(), turned, {});
  EXPECT_EQ(view.opacity.at<float>(120, 310), 0.0F);
  EXPECT_EQ(view.depth.at<float>(120, 310), 0.0F);
  EXPECT_EQ(view.opacity.at<float>(120, 20), 1.0F);
  // Filled from its border.
  EXPECT_EQ(view.image.at<std::uint8_t>(120, 310), view.image.at<std::uint8_t>(120, 319));
  const RenderedView behind =
      MakeWarp({}).Render(*BentCamera(), {ExpSo3({0, M_PI, 0}), {0, 0, 0}}, {});
  EXPECT_EQ(cv::countNonZero(behind.opacity), 0);
}

TEST(DepthWarpRendererTest, NearThingsHideFarOnes) {
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(50));
  RangeMap ranges{cv::Mat(240, 320, CV_32FC1, cv::Scalar(4)), cv::Mat::zeros(240, 320, CV_32FC1)};
  const cv::Rect box(140, 100, 40, 40);
  image(box).setTo(200);
  ranges.range_m(box).setTo(1);
  const DepthWarpRenderer warp(image, ranges, BentCamera(), {});
  const RenderedView view =
      warp.Render(*BentCamera(), {Eigen::Quaterniond::Identity(), {0.3, 0, 0}}, {});
  // 60 px to the left, over what is 15 px to the left; a hole where it was, beside the background.
  EXPECT_EQ(view.image.at<std::uint8_t>(120, 100), 200);
  EXPECT_NEAR(view.depth.at<float>(120, 100), 1, 0.1);
  EXPECT_EQ(view.opacity.at<float>(120, 140), 0.0F);
  EXPECT_EQ(view.image.at<std::uint8_t>(120, 200), 50);
}

TEST(DepthWarpRendererTest, AppliesTheExposure) {
  const RenderedView view = MakeWarp({}).Render(*BentCamera(), {}, {0.5F, 0.1F, 1});
  const RenderedView real = RoomRenderer().Render(*BentCamera(), {}, {});
  EXPECT_NEAR(view.image.at<std::uint8_t>(100, 100),
              0.5 * real.image.at<std::uint8_t>(100, 100) + 25.5,
              1.0);
}

// A smoothly painted square, 2 m away and 1 m wide, before a wall at 4 m: what each pixel shows is
// known exactly.
class SquareBeforeWall {
 public:
  struct Hit {
    Eigen::Vector3d p_N;
    double range = 0;
    bool is_square = false;
  };
  static Hit Cast(const Rigid3& T_N_C, const Eigen::Vector2d& pixel) {
    const Eigen::Vector3d ray = T_N_C.q * BentCamera()->Unproject(pixel);
    for (const double z : {2.0, 4.0}) {
      const double range = (z - T_N_C.t.z()) / ray.z();
      const Eigen::Vector3d p_N = T_N_C.t + range * ray;
      if (z == 4.0 || p_N.head<2>().cwiseAbs().maxCoeff() < 0.5) {
        return {p_N, range, z == 2.0};
      }
    }
    return {};
  }
  static double Grey(const Hit& hit) {
    const double wave = std::sin(9 * hit.p_N.x()) * std::cos(7 * hit.p_N.y());
    return (hit.is_square ? 190 : 70) + 40 * wave;
  }
  // With ranges as a 16-bit image in millimetres has them.
  static DepthWarpRenderer Warp(const Rigid3& T_N_C) {
    cv::Mat image(240, 320, CV_8UC1);
    cv::Mat range(240, 320, CV_32FC1);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const Hit hit = Cast(T_N_C, {x, y});
        image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(Grey(hit));
        range.at<float>(y, x) = static_cast<float>(1e-3 * std::round(1e3 * hit.range));
      }
    }
    return {image, DensifyDepthImage(range), BentCamera(), T_N_C, 1};
  }
};

TEST(DepthWarpRendererTest, ADepthImageGivesWhatTheCameraBesideItSees) {
  using Scene = SquareBeforeWall;
  const Rigid3 T_N_C{ExpSo3({0.02, 0.03, 0.01}), {0.05, -0.02, 0.1}};
  const Rigid3 T_N_V = T_N_C * Rigid3{ExpSo3({0.03, -0.06, 0.1}), {0.35, 0.2, -0.15}};
  const RenderedView view = Scene::Warp(T_N_C).Render(*BentCamera(), T_N_V, {});
  int shown = 0;
  int wrong_grey = 0;
  int wrong_depth = 0;
  int hidden = 0;
  int not_masked = 0;
  int lost = 0;
  for (int y = 0; y < view.image.rows; ++y) {
    for (int x = 0; x < view.image.cols; ++x) {
      const Scene::Hit truth = Scene::Cast(T_N_V, {x, y});
      const auto seen_at = BentCamera()->Project(T_N_C.Inverse() * truth.p_N);
      const bool is_seen = seen_at && BentCamera()->IsInImage(*seen_at) &&
                           Scene::Cast(T_N_C, *seen_at).is_square == truth.is_square;
      const bool is_shown = view.opacity.at<float>(y, x) > 0;
      shown += is_shown ? 1 : 0;
      hidden += is_seen ? 0 : 1;
      lost += is_seen && !is_shown ? 1 : 0;
      not_masked += !is_seen && is_shown ? 1 : 0;
      if (is_seen && is_shown) {
        const double error = std::abs(view.image.at<std::uint8_t>(y, x) - Scene::Grey(truth));
        wrong_grey += error > 3 ? 1 : 0;
        const auto depth = static_cast<double>(view.depth.at<float>(y, x));
        wrong_depth += std::abs(depth - truth.range) > 0.01 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(shown, 50000);
  EXPECT_GT(hidden, 5000);  // beyond the image, and behind the square
  // But along edges: the square's outline is 400 px long, the image's 1120, and interpolation of
  // grey values reaches 2 px across.
  EXPECT_LT(wrong_grey, 700);
  EXPECT_LT(wrong_depth, 100);
  EXPECT_LT(not_masked, 400);
  EXPECT_LT(lost, 1500);
}

TEST(DepthWarpRendererTest, ADepthImagesSquareHidesTheWallWhateverTheOrder) {
  using Scene = SquareBeforeWall;
  for (const double side : {-0.4, 0.4}) {
    const Rigid3 T_N_V{Eigen::Quaterniond::Identity(), {side, 0, 0}};
    const RenderedView view = Scene::Warp({}).Render(*BentCamera(), T_N_V, {});
    const auto middle = BentCamera()->Project(T_N_V.Inverse() * Eigen::Vector3d(0, 0, 2));
    const cv::Point at(cvRound(middle->x()), cvRound(middle->y()));
    EXPECT_NEAR(view.depth.at<float>(at), Scene::Cast(T_N_V, *middle).range, 0.01);
    EXPECT_GT(view.image.at<std::uint8_t>(at), 140);
    // What it hid is a hole, 20 px wide, on the side that the camera went to.
    const cv::Point uncovered(at.x + (side > 0 ? 60 : -60), at.y);
    EXPECT_EQ(view.opacity.at<float>(uncovered), 0.0F);
  }
}

TEST(DensifyDepthImageTest, KeepsWhatIsKnownAndFillsSmallGaps) {
  cv::Mat range(100, 120, CV_32FC1, cv::Scalar(3));
  range(cv::Rect(20, 20, 6, 6)).setTo(0);
  range(cv::Rect(60, 40, 40, 40)).setTo(0);
  const RangeMap map = DensifyDepthImage(range);
  EXPECT_EQ(map.range_m.at<float>(10, 10), 3.0F);
  EXPECT_NEAR(map.variance.at<float>(10, 10), 9e-4, 1e-6);
  EXPECT_NEAR(map.range_m.at<float>(23, 23), 3, 1e-4);
  EXPECT_NEAR(map.variance.at<float>(23, 23), 9e-4, 1e-4);
  EXPECT_EQ(map.range_m.at<float>(60, 80), 0.0F);  // too wide
  EXPECT_EQ(cv::countNonZero(DensifyDepthImage(cv::Mat::zeros(20, 20, CV_32FC1)).range_m), 0);
}

TEST(DensifyDepthImageTest, IsUnsureOfAGapAlongAnEdge) {
  cv::Mat range(100, 120, CV_32FC1, cv::Scalar(4));
  range.colRange(0, 60).setTo(2);
  range.colRange(57, 63).setTo(0);
  const RangeMap map = DensifyDepthImage(range);
  const float between = map.range_m.at<float>(50, 60);
  EXPECT_GT(between, 2.2F);
  EXPECT_LT(between, 3.8F);
  EXPECT_GT(std::sqrt(map.variance.at<float>(50, 60)), 0.3F * between);
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
