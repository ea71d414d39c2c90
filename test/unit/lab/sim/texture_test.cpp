#include "deja_view/lab/sim/texture.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view::sim {
namespace {

cv::Mat Checkerboard(int size) {
  cv::Mat image(size, size, CV_32FC1);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      image.at<float>(y, x) = (x + y) % 2 == 0 ? 1.0F : 0.0F;
    }
  }
  return image;
}

TEST(Texture, GivesTexelsAtTheirCentresAndRepeats) {
  cv::Mat image(4, 4, CV_32FC1);
  for (int i = 0; i < 16; ++i) {
    image.at<float>(i / 4, i % 4) = static_cast<float>(i) / 16.0F;
  }
  const Texture texture(image);
  EXPECT_EQ(texture.levels(), 3);
  for (int i = 0; i < 16; ++i) {
    const float u = (static_cast<float>(i % 4) + 0.5F) / 4;
    const float v = (static_cast<float>(i / 4) + 0.5F) / 4;
    for (const float period : {0.0F, 3.0F, -2.0F}) {
      EXPECT_NEAR(texture.Sample(u + period, v - period, 0), static_cast<float>(i) / 16.0F, 4e-3);
    }
  }
}

TEST(Texture, IsLinearBetweenTexelsAlsoAcrossTheSeam) {
  cv::Mat image = cv::Mat::zeros(2, 2, CV_32FC1);
  image.col(1).setTo(1.0F);
  const Texture texture(image);
  EXPECT_NEAR(texture.Sample(0.25F, 0.1F, 0), 0.0, 1e-4);
  EXPECT_NEAR(texture.Sample(0.375F, 0.1F, 0), 0.25, 1e-4);
  EXPECT_NEAR(texture.Sample(0.875F, 0.1F, 0), 0.75, 1e-4);
  EXPECT_NEAR(texture.Sample(-0.125F, 0.1F, 0), 0.75, 1e-4);
}

TEST(Texture, FarAwayIsItsMean) {
  const Texture texture(Checkerboard(64));
  EXPECT_NEAR(texture.Sample(0.3F, 0.6F, 1.0F), 0.5, 4e-3);
  EXPECT_NEAR(texture.Sample(0.3F, 0.6F, 100.0F), 0.5, 4e-3);
  EXPECT_GT(std::abs(texture.Sample(0.5F / 64, 0.5F / 64, 0) - 0.5), 0.49);
  EXPECT_NEAR(texture.Sample(0.5F / 64, 0.5F / 64, 2.0F / 64), 0.5, 4e-3);
}

TEST(Texture, BlursSteadilyWithFootprint) {
  const Texture texture(Checkerboard(64));
  float last = 1.1F;
  for (float texels = 1.0F; texels < 2.0F; texels += 0.1F) {
    const float value = texture.Sample(0.5F / 64, 0.5F / 64, texels / 64);
    EXPECT_LT(value, last);
    last = value;
  }
}

TEST(Texture, RejectsImagesThatCannotRepeat) {
  EXPECT_THROW(Texture(cv::Mat(3, 3, CV_32FC1, cv::Scalar(0))), CheckError);
  EXPECT_THROW(Texture(cv::Mat(4, 8, CV_32FC1, cv::Scalar(0))), CheckError);
  EXPECT_THROW(Texture(cv::Mat(4, 4, CV_8UC1, cv::Scalar(0))), CheckError);
}

class MaterialTest : public ::testing::TestWithParam<Material> {};

double Contrast(const Texture& texture) {
  double sum = 0;
  double squares = 0;
  const int n = texture.size();
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const double value =
          texture.SampleLevel(0,
                              (static_cast<float>(x) + 0.5F) / static_cast<float>(n),
                              (static_cast<float>(y) + 0.5F) / static_cast<float>(n));
      EXPECT_GT(value, 0.01);
      EXPECT_LT(value, 0.96);
      sum += value;
      squares += value * value;
    }
  }
  const double mean = sum / (n * n);
  return std::sqrt(std::max(0.0, squares / (n * n) - mean * mean));
}

TEST_P(MaterialTest, HasContrastThatStrengthScales) {
  const double strong = Contrast(MakeTexture(GetParam(), 128, 1.0, Rng(3, 4)));
  const double weak = Contrast(MakeTexture(GetParam(), 128, 0.25, Rng(3, 4)));
  const double bare = Contrast(MakeTexture(GetParam(), 128, 0.0, Rng(3, 4)));
  EXPECT_GT(strong, 0.02);
  EXPECT_NEAR(weak / strong, 0.25, 0.05);
  EXPECT_LT(bare, 1e-4);
}

TEST_P(MaterialTest, DependsOnTheSeedAlone) {
  const Texture a = MakeTexture(GetParam(), 64, 1.0, Rng(3, 4));
  const Texture b = MakeTexture(GetParam(), 64, 1.0, Rng(3, 4));
  const Texture c = MakeTexture(GetParam(), 64, 1.0, Rng(3, 5));
  int differences = 0;
  for (int i = 0; i < 64 * 64; ++i) {
    const float u = (static_cast<float>(i % 64) + 0.5F) / 64;
    const float v = (static_cast<float>(i / 64) + 0.5F) / 64;
    ASSERT_EQ(a.SampleLevel(0, u, v), b.SampleLevel(0, u, v));
    differences += a.SampleLevel(0, u, v) != c.SampleLevel(0, u, v) ? 1 : 0;
  }
  EXPECT_GT(differences, 100);
}

INSTANTIATE_TEST_SUITE_P(All,
                         MaterialTest,
                         ::testing::Values(Material::kConcrete,
                                           Material::kPlaster,
                                           Material::kBrick,
                                           Material::kPlanks,
                                           Material::kPanels,
                                           Material::kPoster,
                                           Material::kShelf,
                                           Material::kCamouflage));

}  // namespace
}  // namespace deja_view::sim
