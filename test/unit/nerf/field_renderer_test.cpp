#include "deja_view/nerf/field_renderer.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>

#include "closed_form.hpp"
#include "test_cameras.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view::nerf {
namespace {

PinholeCamera OddCamera() {
  return PinholeOf(37, 21, 25, 18, 10);
}

bool Equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(FieldRenderer, ShowsASlab) {
  constexpr double kSigma = 0.5;
  const auto field = std::make_shared<RadianceField>(ConstantField(kSigma, 0.8F));
  // Looks along x (camera z), from 2 m before the box, whose depth is 4 m.
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Rigid3 T_N_C{Eigen::Quaterniond(R), {-3, 0.5, 0}};
  ViewRenderOptions options;
  options.gain = 0.5F;
  options.bias = 0.1F;
  const RenderedView view = FieldRenderer(field).Render(OddCamera(), T_N_C, options);
  const double opacity = 1 - std::exp(-4 * kSigma);
  EXPECT_NEAR(view.opacity.at<float>(10, 18), opacity, 1e-3);
  EXPECT_NEAR(view.image.at<std::uint8_t>(10, 18), 255 * (0.5 * 0.8 * opacity + 0.1), 1.5);
  const double out = std::exp(-4 * kSigma);
  const double mean = 1 / kSigma - 4 * out / (1 - out);
  const double square = 2 / (kSigma * kSigma) - out / (1 - out) * (16 + 8 / kSigma);
  EXPECT_NEAR(view.depth.at<float>(10, 18), 2 + mean, 5e-3);
  EXPECT_NEAR(view.depth_variance.at<float>(10, 18), square - mean * mean, 2e-2);
}

TEST(FieldRenderer, ShowsThreeChannels) {
  const auto field = std::make_shared<RadianceField>(ConstantField(50, 0.2F, 3));
  const RenderedView view = FieldRenderer(field).Render(OddCamera(), {}, {});
  EXPECT_EQ(view.image.type(), CV_8UC3);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(view.image.at<cv::Vec3b>(4, 5)[c], 51, 1);
  }
}

TEST(FieldRenderer, ThreadsDoNotChangeABit) {
  const auto field = std::make_shared<RadianceField>(
      SmallFieldOptions(), MarchOptions(), ConstantField(1, 0.5F).box, 1, 3);
  const FieldRenderer renderer(field);
  const Rigid3 T_N_C{ExpSo3({0.1, 0.9, 0.2}), {0.1, 0.2, 0}};
  ViewRenderOptions options;
  options.threads = 1;
  const RenderedView one = renderer.Render(OddCamera(), T_N_C, options);
  for (const int threads : {2, 5}) {
    options.threads = threads;
    const RenderedView many = renderer.Render(OddCamera(), T_N_C, options);
    EXPECT_TRUE(Equal(one.image, many.image));
    EXPECT_TRUE(Equal(one.depth, many.depth));
    EXPECT_TRUE(Equal(one.depth_variance, many.depth_variance));
    EXPECT_TRUE(Equal(one.opacity, many.opacity));
  }
}

TEST(FieldRenderer, ExposureLiesBetweenItsNeighbours) {
  auto field = std::make_shared<RadianceField>(ConstantField(1, 0.5F));
  field->exposures = {{"b", 200, 2, 0.2F, {}}, {"a", 100, 1, 0, {}}, {"unknown", 0, 9, 9, {}}};
  const FieldRenderer renderer(field);
  EXPECT_NEAR(renderer.ExposureAt(125).gain, 1.25F, 1e-6F);
  EXPECT_NEAR(renderer.ExposureAt(125).bias, 0.05F, 1e-6F);
  EXPECT_EQ(renderer.ExposureAt(50).gain, 1);
  EXPECT_EQ(renderer.ExposureAt(500).gain, 2);
  EXPECT_EQ(renderer.ExposureAt(0).gain, 1);
}

}  // namespace
}  // namespace deja_view::nerf
