#include "deja_view/nerf/posed_images.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

#include "image_files.hpp"
#include <gmock/gmock.h>

namespace deja_view::nerf {
namespace {

class PosedImagesTest : public ImageFilesTest {
 protected:
  PosedImage MakeImage(const cv::Mat& pixels = cv::Mat(12, 16, CV_8UC1, 77.0)) const {
    PosedImage image;
    image.path = WriteImage("image.png", pixels);
    image.name = "image";
    image.camera = SmallCamera();
    return image;
  }
};

TEST_F(PosedImagesTest, LoadShrinksImageCameraAndPoints) {
  PosedImage image = MakeImage();
  image.points = {{7.5F, 5.5F, 2.0F}, {0.0F, 0.0F, 3.0F}};
  const std::vector<TrainingView> views = LoadViews({image}, {3, 0.5, 0, 16, 1});
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].image.type(), CV_8UC3);
  EXPECT_EQ(views[0].image.size(), cv::Size(8, 6));
  EXPECT_EQ(views[0].camera->width(), 8);
  EXPECT_EQ(views[0].image.at<cv::Vec3b>(2, 2)[1], 77);
  // A point and its pixel shrink alike.
  ASSERT_EQ(views[0].points.size(), 2U);
  EXPECT_EQ(views[0].points[0].u, 3.5F);
  EXPECT_EQ(views[0].points[1].v, -0.25F);
  EXPECT_EQ(views[0].points[1].range, 3.0F);
}

TEST_F(PosedImagesTest, LoadShrinksToTheLongestSide) {
  LoadOptions options;
  options.max_side = 4;
  EXPECT_EQ(LoadViews({MakeImage()}, options)[0].image.size(), cv::Size(4, 3));
  options.max_side = 100;
  EXPECT_EQ(LoadViews({MakeImage()}, options)[0].image.size(), cv::Size(16, 12));
  options.scale = 0.5;
  EXPECT_EQ(LoadViews({MakeImage()}, options)[0].image.size(), cv::Size(8, 6));
}

TEST_F(PosedImagesTest, LoadTakesImagesThatAreNoFiles) {
  PosedImage image = MakeImage();
  image.path = "bag:12";
  image.read = [] { return cv::Mat(12, 16, CV_8UC3, cv::Scalar(10, 20, 30)); };
  EXPECT_EQ(LoadViews({image}, {3, 1, 0, 0, 1})[0].image.at<cv::Vec3b>(0, 0)[2], 30);
  EXPECT_EQ(LoadViews({image}, {1, 1, 0, 0, 1})[0].image.type(), CV_8UC1);
}

TEST_F(PosedImagesTest, LoadRefusesOtherSizesAndBrokenFiles) {
  const auto error = [](const PosedImage& image) {
    return MessageOf<InputError>([&] { LoadViews({image}, {}); });
  };
  EXPECT_THAT(error(MakeImage(cv::Mat(10, 10, CV_8UC1, 1.0))), Says("image.png", "10x10", "16x12"));
  PosedImage image = MakeImage();
  Write("image.png", "not a picture");
  EXPECT_THAT(error(image), Says("can't be read as an image"));
}

TEST_F(PosedImagesTest, CountsTheChannelsThatDiffer) {
  EXPECT_EQ(CountChannels({MakeImage()}), 1);
  EXPECT_EQ(CountChannels({MakeImage(cv::Mat(12, 16, CV_8UC3, cv::Scalar::all(9)))}), 1);
  EXPECT_EQ(CountChannels({MakeImage(cv::Mat(12, 16, CV_8UC3, cv::Scalar(9, 9, 60)))}), 3);
  EXPECT_EQ(CountChannels({}), 1);
}

TEST_F(PosedImagesTest, DepthMapsBecomeDistancesAlongTheRay) {
  PosedImage image = MakeImage();
  cv::Mat millimetres(12, 16, CV_16UC1, cv::Scalar(2000));
  millimetres.at<std::uint16_t>(0, 0) = 65535;
  millimetres.at<std::uint16_t>(0, 1) = 0;
  image.depth.path = WriteImage("depth.png", millimetres);
  const cv::Mat range = ReadDepthMap(image);
  EXPECT_EQ(range.at<float>(0, 0), 0);
  EXPECT_EQ(range.at<float>(0, 1), 0);
  // Pixel (2.5, 5.5) would be at x/z = 0.5; (3, 5) is at (-0.45, -0.05, 1).
  EXPECT_NEAR(range.at<float>(5, 3), 2 * std::sqrt(1 + 0.45 * 0.45 + 0.05 * 0.05), 1e-5);
  // Sampled at (2, 2), (6, 2) ... of a grid of 4 px.
  const auto points = LoadViews({image}, {1, 1, 0, 4, 1})[0].points;
  ASSERT_EQ(points.size(), 12U);
  EXPECT_EQ(points[1].u, 6);
  EXPECT_EQ(points[1].v, 2);
  EXPECT_EQ(points[1].range, range.at<float>(2, 6));
  EXPECT_TRUE(LoadViews({image}, {1, 1, 0, 0, 1})[0].points.empty());
}

TEST_F(PosedImagesTest, DepthMapsOfOtherKindsAreRefused) {
  PosedImage image = MakeImage();
  const auto error = [&](const cv::Mat& depth) {
    image.depth.path = WriteImage("depth.png", depth);
    return MessageOf<InputError>([&] { ReadDepthMap(image); });
  };
  EXPECT_THAT(error(cv::Mat(12, 16, CV_8UC1, 3.0)), Says("depth.png", "16-bit"));
  EXPECT_THAT(error(cv::Mat(12, 15, CV_16UC1, 3.0)), Says("16x12"));
  image.depth.path = directory_ / "none.png";
  EXPECT_THAT(MessageOf<InputError>([&] { ReadDepthMap(image); }), Says("none.png"));
}

TEST_F(PosedImagesTest, StrayPointsAreDropped) {
  std::vector<PosedImage> images(2, MakeImage());
  images[1].T_N_C = {ExpSo3({0, 0.5 * M_PI, 0}), {0, 0, 20}};  // looks along x of N
  for (int i = 0; i <= 100; ++i) {
    const float t = 0.01F * static_cast<float>(i);
    images[0].points.push_back({16 * t, 12 * t, 10 + 40 * t});
  }
  images[1].points = {{7.5F, 5.5F, 5.0F}, {7.5F, 5.5F, 500.0F}};
  DropStrayPoints(&images);
  EXPECT_EQ(images[0].points.size(), 101U);
  ASSERT_EQ(images[1].points.size(), 1U);
  EXPECT_EQ(images[1].points[0].range, 5.0F);
}

TEST(HoldOut, TakesEveryNth) {
  const std::vector<PosedImage> images(7);
  const Split split = HoldOut(images, 3);
  EXPECT_EQ(split.held_out.size(), 3U);
  EXPECT_EQ(split.training.size(), 4U);
  // The last image is held out: what comes next to it is before it.
  EXPECT_EQ(split.next, (std::vector<std::size_t>{0, 2, 3}));
  EXPECT_TRUE(HoldOut(images, 0).held_out.empty());
}

TEST(HoldOut, TakesRareDepthMapsToo) {
  std::vector<PosedImage> images(8);
  for (const std::size_t i : {0U, 1U, 5U}) {
    images[i].name = std::to_string(i);
    images[i].depth.path = "depth.png";
  }
  const Split split = HoldOut(images, 4);
  EXPECT_EQ(split.held_out.size(), 2U);
  ASSERT_EQ(split.depth_checks.size(), 2U);
  EXPECT_EQ(split.depth_checks[1].name, "5");
  EXPECT_EQ(split.training.size(), 4U);
  // Where most have one, they are for training; without holding out all are.
  EXPECT_EQ(HoldOut(images, 0).training.size(), 8U);
  for (PosedImage& image : images) {
    image.depth.path = "depth.png";
  }
  EXPECT_TRUE(HoldOut(images, 4).depth_checks.empty());
}

}  // namespace
}  // namespace deja_view::nerf
