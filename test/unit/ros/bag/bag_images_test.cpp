#include "deja_view/ros/bag/bag_images.hpp"

#include "bag_fixture.hpp"
#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include <sensor_msgs/CompressedImage.h>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class BagImagesTest : public BagTest {};

TEST_F(BagImagesTest, ListsByStampAndDecodesLater) {
  std::vector<BagImage> images =
      ListBagImages(std::make_shared<const BagReader>(WriteFlight("a.bag", 5)), "/cam0/image_raw");
  ASSERT_EQ(images.size(), 5U);
  EXPECT_EQ(images[3].stamp_ns, kStart + 300 * kMillisecond);
  // In any order, though the list of the bag's messages is gone.
  for (const std::size_t i : {4U, 0U, 3U}) {
    const cv::Mat image = images[i].read();
    EXPECT_EQ(image.size(), cv::Size(64, 48));
    EXPECT_EQ(image.type(), CV_8UC1);
    EXPECT_EQ(image.at<std::uint8_t>(7, 7), i);
  }
}

TEST_F(BagImagesTest, KeepsColorsAndSkipsDoubledStamps) {
  sensor_msgs::Image rgb = ToImage(cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 3)), kStart, "cam0");
  rgb.encoding = "rgb8";
  sensor_msgs::CompressedImage png;
  png.header.stamp = ToRosTime(kStart + 5);
  cv::imencode(".png", cv::Mat(2, 2, CV_8UC3, cv::Scalar(4, 5, 6)), png.data);
  {
    BagWriter bag(Path("a.bag"));
    bag.Write("/rgb", kStart, rgb);
    bag.Write("/rgb", kStart + 1, rgb);
    bag.Write("/png", kStart + 2, png);
    bag.Close();
  }
  const auto bag = std::make_shared<const BagReader>(Path("a.bag"));
  const auto images = ListBagImages(bag, "/rgb");
  ASSERT_EQ(images.size(), 1U);
  EXPECT_EQ(images[0].read().at<cv::Vec3b>(0, 0), cv::Vec3b(3, 2, 1));
  const auto compressed = ListBagImages(bag, "/png");
  EXPECT_EQ(compressed.at(0).stamp_ns, kStart + 5);
  EXPECT_EQ(compressed[0].read().at<cv::Vec3b>(1, 1), cv::Vec3b(4, 5, 6));
  EXPECT_THAT(ErrorOf([&] { ListBagImages(bag, "/none"); }),
              AllOf(HasSubstr("'/none'"), HasSubstr("/png")));
}

TEST_F(BagImagesTest, KeyframesHaveTheCamerasPoseOfTheirTime) {
  const auto keyframes = ReadBagKeyframes(BagReader(WriteFlight("a.bag", 6)), VioTopics());
  ASSERT_EQ(keyframes.size(), 6U);
  EXPECT_EQ(keyframes[2].stamp_ns, kStart + 200 * kMillisecond);
  EXPECT_EQ(keyframes[2].points.size(), 2U);
  EXPECT_EQ(keyframes[2].T_W_C.t.x(), 2.25);
  EXPECT_EQ(keyframes[5].T_W_C.t.x(), 5.28);
}

TEST_F(BagImagesTest, KeyframesWithoutPartnersAreErrors) {
  const VioTopics topics;
  {
    BagWriter bag(Path("a.bag"));
    bag.Write(topics.extrinsic, kStart, MakeOdometry(kStart, 0));
    bag.Write(topics.keyframe_pose, kStart, MakeOdometry(kStart, 0));
    bag.Write(topics.keyframe_point, kStart, MakePoints(kStart + 1, 3));
    bag.Close();
  }
  EXPECT_THAT(ErrorOf([&] { ReadBagKeyframes(BagReader(Path("a.bag")), topics); }),
              HasSubstr("no keyframe has a pose"));
  VioTopics others;
  others.keyframe_point = "/none";
  EXPECT_THAT(ErrorOf([&] { ReadBagKeyframes(BagReader(Path("a.bag")), others); }),
              HasSubstr("'/none'"));
}

}  // namespace
}  // namespace deja_view
