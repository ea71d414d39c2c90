#include "deja_view/lab/sim/renderer.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

#include "small_world.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view::sim {
namespace {

bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Renderer, RangeIsExact) {
  const auto camera = TinyCamera();
  const Renderer renderer(TinyWorld(), camera, 1, 1);
  const Rigid3 T_W_C = LookAlong(*TinyWorld(), 2.1);
  const cv::Mat range = renderer.RenderRange(T_W_C);
  int differences = 0;
  for (int y = 0; y < range.rows; y += 3) {
    for (int x = 0; x < range.cols; x += 3) {
      const Eigen::Vector3d ray = T_W_C.q * camera->Unproject({x, y});
      const auto hit = CastRay(TinyWorld()->scene(), T_W_C.t, ray);
      ASSERT_TRUE(hit);
      differences += std::abs(range.at<float>(y, x) - hit->range) > 2e-4F * hit->range ? 1 : 0;
    }
  }
  EXPECT_LE(differences, 2);  // rays along an edge
}

TEST(Renderer, RadianceIsFiniteAndEveryPixelSeesSomething) {
  const Renderer renderer(TinyWorld(), TinyCamera(), 4, 1);
  for (const double yaw : {0.0, 1.5, 3.0, 4.5}) {
    const cv::Mat radiance = renderer.RenderRadiance(LookAlong(*TinyWorld(), yaw));
    double low = 0;
    double high = 0;
    EXPECT_TRUE(cv::checkRange(radiance));
    cv::minMaxLoc(radiance, &low, &high);
    EXPECT_GE(low, 0.0);
    EXPECT_GT(cv::mean(radiance)[0], 0.05);
  }
}

TEST(Renderer, IsTheSameOnAnyNumberOfThreads) {
  const Renderer one(TinyWorld(), TinyCamera(), 2, 1);
  const Renderer three(TinyWorld(), TinyCamera(), 2, 3);
  const Rigid3 T_W_C = LookAlong(*TinyWorld(), 0.4);
  EXPECT_TRUE(SameBits(one.RenderRadiance(T_W_C), three.RenderRadiance(T_W_C)));
  EXPECT_TRUE(SameBits(one.RenderRange(T_W_C), three.RenderRange(T_W_C)));
}

TEST(Renderer, ThreeDimensionalPointsReproject) {
  const auto camera = TinyCamera();
  const Renderer renderer(TinyWorld(), camera, 1, 1);
  const Rigid3 T_W_A = LookAlong(*TinyWorld(), 3.0);
  Rigid3 T_W_B = T_W_A;
  T_W_B.t += Eigen::Vector3d(-0.1, 0.15, 0.05);
  const cv::Mat range_A = renderer.RenderRange(T_W_A);
  const cv::Mat range_B = renderer.RenderRange(T_W_B);
  int seen = 0;
  int agree = 0;
  for (int y = 0; y < range_A.rows; y += 4) {
    for (int x = 0; x < range_A.cols; x += 4) {
      const Eigen::Vector3d p_W =
          T_W_A * (static_cast<double>(range_A.at<float>(y, x)) * camera->Unproject({x, y}));
      const Eigen::Vector3d p_B = T_W_B.Inverse() * p_W;
      const auto pixel = camera->Project(p_B);
      if (pixel && camera->IsInImage(*pixel)) {
        const int px = static_cast<int>(std::lround(pixel->x()));
        const int py = static_cast<int>(std::lround(pixel->y()));
        ++seen;
        agree += std::abs(range_B.at<float>(py, px) - p_B.norm()) < 0.05 * p_B.norm() ? 1 : 0;
      }
    }
  }
  EXPECT_GT(seen, 500);
  EXPECT_GT(agree, 0.9 * seen);
}

TEST(Renderer, FourSamplesComeNearToManySamples) {
  const Renderer few(TinyWorld(), TinyCamera(), 4, 1);
  const Renderer many(TinyWorld(), TinyCamera(), 64, 1);
  const Rigid3 T_W_C = LookAlong(*TinyWorld(), 1.0);
  const cv::Mat a = RenderView(few, T_W_C, 0.8).image;
  const cv::Mat b = RenderView(many, T_W_C, 0.8).image;
  const double error = std::sqrt(cv::norm(a, b, cv::NORM_L2SQR) / static_cast<double>(a.total()));
  EXPECT_LT(error, 6.0);
  EXPECT_GT(error, 0.0);
}

TEST(Renderer, MotionBlursAcrossTheMotion) {
  const Renderer renderer(TinyWorld(), TinyCamera(), 8, 1);
  const Rigid3 T_W_C = LookAlong(*TinyWorld(), 1.0);
  std::vector<Rigid3> turning;
  for (int i = 0; i < 8; ++i) {
    turning.push_back({FromYaw(0.01 * (i - 3.5)) * T_W_C.q, T_W_C.t});
  }
  const auto roughness = [](const cv::Mat& image) {
    const cv::Mat left = image.colRange(0, image.cols - 1);
    return cv::norm(left, image.colRange(1, image.cols), cv::NORM_L1);
  };
  EXPECT_LT(roughness(renderer.RenderRadiance(turning)),
            0.7 * roughness(renderer.RenderRadiance(T_W_C)));
}

TEST(Renderer, WantsOnePosePerSample) {
  const Renderer renderer(TinyWorld(), TinyCamera(), 4, 1);
  EXPECT_THROW(renderer.RenderRadiance(std::vector<Rigid3>(3)), CheckError);
  EXPECT_THROW(Renderer(TinyWorld(), TinyCamera(), 0, 1), CheckError);
}

}  // namespace
}  // namespace deja_view::sim
