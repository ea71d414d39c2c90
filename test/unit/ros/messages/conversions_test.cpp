#include "deja_view/ros/messages/conversions.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <boost/make_shared.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const std::string kTopic = "/some/topic";

std::string ErrorOf(const std::function<void()>& body) {
  try {
    body();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no InputError";
}

sensor_msgs::PointCloud MakePoints() {
  sensor_msgs::PointCloud message;
  message.points.resize(2);
  message.points[0].x = 1;
  message.points[0].y = 2;
  message.points[0].z = 3;
  message.points[1].x = -1;
  message.channels.resize(2);
  message.channels[0].values = {0.1F, 0.2F, 300.5F, 200.25F, 41};
  message.channels[1].values = {0.3F, 0.4F, 17, 18, 16777215};
  return message;
}

boost::shared_ptr<sensor_msgs::Image> MakeImage(const std::string& encoding,
                                                std::uint32_t width,
                                                std::uint32_t height,
                                                std::uint32_t step) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->encoding = encoding;
  message->width = width;
  message->height = height;
  message->step = step;
  message->data.resize(std::size_t{step} * height);
  return message;
}

TEST(ConversionsTest, StampsKeepTheirNanoseconds) {
  for (const std::int64_t stamp : {std::int64_t{0}, std::int64_t{1403636632538560256}}) {
    EXPECT_EQ(ToNanoseconds(ToRosTime(stamp)), stamp);
  }
  EXPECT_THROW(ToRosTime(-1), CheckError);
  EXPECT_THROW(ToRosTime(std::int64_t{5000000000} * 1000000000), CheckError);
  ros::Time beyond;
  beyond.sec = beyond.nsec = std::numeric_limits<std::uint32_t>::max();
  const ros::Time latest = ToRosTime(ToNanoseconds(beyond));
  EXPECT_EQ(latest.sec, beyond.sec);
  EXPECT_EQ(latest.nsec, 999'999'999U);
}

TEST(ConversionsTest, PoseRoundTrip) {
  const Rigid3 pose{Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {1, -2, 3}};
  const Rigid3 back = FromPose(ToPose(pose), kTopic);
  EXPECT_EQ(back.t, pose.t);
  EXPECT_EQ(back.q.coeffs(), pose.q.coeffs());
}

TEST(ConversionsTest, RefusesAPoseThatIsNone) {
  geometry_msgs::Pose message = ToPose(Rigid3::Identity());
  message.position.y = kNan;
  EXPECT_THAT(ErrorOf([&] { FromPose(message, kTopic); }),
              AllOf(HasSubstr(kTopic), HasSubstr("nan"), HasSubstr("finite")));
  message.position.y = 0;
  message.orientation.w = 0;
  EXPECT_THAT(ErrorOf([&] { FromPose(message, kTopic); }),
              AllOf(HasSubstr(kTopic), HasSubstr("norm 0")));
}

TEST(ConversionsTest, AnOrientationOfZerosIsThatOfAVioThatHasNotBegun) {
  nav_msgs::Odometry message;
  EXPECT_TRUE(IsUninitialised(message));
  message.pose.pose.orientation.z = 1e-9;
  EXPECT_FALSE(IsUninitialised(message));
}

TEST(ConversionsTest, NormalisesARoundedQuaternion) {
  geometry_msgs::Pose message = ToPose(Rigid3::Identity());
  message.orientation.w = 0.999;
  EXPECT_DOUBLE_EQ(FromPose(message, kTopic).q.norm(), 1.0);
}

TEST(ConversionsTest, ReadsOneChannelPerPoint) {
  const std::vector<TrackedPoint> points = FromKeyframePoints(MakePoints(), kTopic);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].p_W, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(points[0].pixel, Eigen::Vector2f(300.5F, 200.25F));
  EXPECT_EQ(points[0].feature_id, 41);
  EXPECT_EQ(points[1].feature_id, 16777215);
}

TEST(ConversionsTest, RefusesPointsWithoutTheirChannels) {
  sensor_msgs::PointCloud message = MakePoints();
  message.channels.pop_back();
  EXPECT_THAT(ErrorOf([&] { FromKeyframePoints(message, kTopic); }),
              AllOf(HasSubstr(kTopic), HasSubstr("1 channels for 2 points")));
  message = MakePoints();
  message.channels[1].values.pop_back();
  EXPECT_THAT(ErrorOf([&] { FromKeyframePoints(message, kTopic); }),
              AllOf(HasSubstr("4 values"), HasSubstr("point 1"), HasSubstr("expected 5")));
}

TEST(ConversionsTest, LeavesOutPointsThatAreNotFinite) {
  sensor_msgs::PointCloud message = MakePoints();
  message.points[0].z = std::numeric_limits<float>::infinity();
  EXPECT_EQ(FromKeyframePoints(message, kTopic).size(), 1U);
  message.channels[1].values[3] = static_cast<float>(kNan);
  EXPECT_TRUE(FromKeyframePoints(message, kTopic).empty());
}

TEST(ConversionsTest, AnIdThatIsNoNumberIsNoId) {
  sensor_msgs::PointCloud message = MakePoints();
  message.channels[0].values[4] = static_cast<float>(kNan);
  message.channels[1].values[4] = 1e30F;
  for (const TrackedPoint& point : FromKeyframePoints(message, kTopic)) {
    EXPECT_EQ(point.feature_id, -1);
  }
}

TEST(ConversionsTest, ReadsTheRelativePoseOfTheVio) {
  nav_msgs::Odometry message;
  message.header.stamp = ToRosTime(5000000001);
  message.pose.pose = ToPose({Eigen::Quaterniond::Identity(), {0.5, 0, -1}});
  message.twist.twist.linear.x = 90;
  message.twist.twist.linear.y = 17;
  const RelativePoseUpdate update = FromRelativePose(message, kTopic);
  EXPECT_EQ(update.stamp_current_ns, 5000000001);
  EXPECT_EQ(update.current, 17);
  EXPECT_DOUBLE_EQ(update.relative_yaw, M_PI / 2);
  EXPECT_EQ(update.T_Bold_Bcurrent.t, Eigen::Vector3d(0.5, 0, -1));
  for (const double bad : {kNan, -1.0, 1e20}) {
    message.twist.twist.linear.y = bad;
    EXPECT_THAT(ErrorOf([&] { FromRelativePose(message, kTopic); }), HasSubstr("keyframe index"));
  }
}

TEST(ConversionsTest, GreyImagesKeepTheirBytes) {
  for (const std::string encoding : {"mono8", "8UC1"}) {
    const auto message = MakeImage(encoding, 3, 2, 4);  // one byte of padding
    message->data = {1, 2, 3, 99, 4, 5, 6, 99};
    const cv::Mat image = FromImage(message, kTopic)();
    ASSERT_EQ(image.type(), CV_8UC1);
    ASSERT_EQ(image.size(), cv::Size(3, 2));
    EXPECT_EQ(image.at<std::uint8_t>(0, 2), 3);
    EXPECT_EQ(image.at<std::uint8_t>(1, 0), 4);
  }
}

TEST(ConversionsTest, ColoursAndDepthsBecomeGrey) {
  const auto check = [](const std::string& encoding,
                        std::uint32_t bytes,
                        const std::vector<std::uint8_t>& pixel,
                        int expected) {
    const auto message = MakeImage(encoding, 2, 1, 2 * bytes);
    std::copy(pixel.begin(), pixel.end(), message->data.begin() + bytes);
    const cv::Mat image = FromImage(message, kTopic)();
    EXPECT_EQ(image.type(), CV_8UC1) << encoding;
    EXPECT_EQ(image.at<std::uint8_t>(0, 0), 0) << encoding;
    EXPECT_EQ(image.at<std::uint8_t>(0, 1), expected) << encoding;
  };
  // 0.299 R + 0.587 G + 0.114 B
  check("rgb8", 3, {200, 100, 50}, 124);
  check("bgr8", 3, {50, 100, 200}, 124);
  check("rgba8", 4, {200, 100, 50, 7}, 124);
  check("bgra8", 4, {50, 100, 200, 7}, 124);
  check("mono16", 2, {0x34, 0x12}, 0x12);
  check("16UC1", 2, {0x34, 0x12}, 0x12);
}

TEST(ConversionsTest, ReadsBigEndianImages) {
  const auto message = MakeImage("mono16", 1, 1, 2);
  message->is_bigendian = 1;
  message->data = {0x12, 0x34};
  EXPECT_EQ(FromImage(message, kTopic)().at<std::uint8_t>(0, 0), 0x12);
}

TEST(ConversionsTest, RowsOf16BitImagesMayStartAtOddAddresses) {
  const auto message = MakeImage("mono16", 1, 2, 3);
  message->data = {0, 0x12, 99, 0, 0x34, 99};
  EXPECT_EQ(FromImage(message, kTopic)().at<std::uint8_t>(1, 0), 0x34);
}

TEST(ConversionsTest, RefusesImagesBeforeDecodingThem) {
  EXPECT_THAT(ErrorOf([] { FromImage(MakeImage("yuv422", 2, 2, 4), kTopic); }),
              AllOf(HasSubstr(kTopic), HasSubstr("yuv422"), HasSubstr("mono8")));
  EXPECT_THAT(ErrorOf([] { FromImage(MakeImage("mono8", 0, 2, 4), kTopic); }),
              HasSubstr("0 x 2 px"));
  EXPECT_THAT(ErrorOf([] { FromImage(MakeImage("rgb8", 2, 2, 5), kTopic); }),
              AllOf(HasSubstr("step 5"), HasSubstr("6 bytes")));
  const auto cut = MakeImage("mono8", 4, 4, 4);
  cut->data.resize(15);
  EXPECT_THAT(ErrorOf([&] { FromImage(cut, kTopic); }),
              AllOf(HasSubstr("15 bytes"), HasSubstr("expected 16")));
  const auto huge = MakeImage("mono8", 4, 4, 4);
  huge->height = 0xFFFFFFFF;
  EXPECT_THAT(ErrorOf([&] { FromImage(huge, kTopic); }), HasSubstr("4294967295"));
}

TEST(ConversionsTest, TheImageSourceKeepsItsMessage) {
  auto message = MakeImage("mono8", 1, 1, 1);
  message->data = {42};
  const ImageSource source = FromImage(message, kTopic);
  message.reset();
  EXPECT_EQ(source().at<std::uint8_t>(0, 0), 42);
}

TEST(ConversionsTest, DecodesCompressedImages) {
  const auto message = boost::make_shared<sensor_msgs::CompressedImage>();
  message->format = "png";
  EXPECT_THAT(ErrorOf([&] { FromCompressedImage(message, kTopic); }), HasSubstr("without data"));
  cv::imencode(".png", cv::Mat(4, 5, CV_8UC1, cv::Scalar(9)), message->data);
  const cv::Mat image = FromCompressedImage(message, kTopic)();
  EXPECT_EQ(image.size(), cv::Size(5, 4));
  EXPECT_EQ(image.at<std::uint8_t>(3, 4), 9);
  message->data.resize(20);
  EXPECT_THAT(ErrorOf([&] { FromCompressedImage(message, kTopic)(); }),
              AllOf(HasSubstr(kTopic), HasSubstr("can't be decoded")));
}

TEST(ConversionsTest, RefusesCompressedImagesThatStateAHugeSize) {
  const auto message = boost::make_shared<sensor_msgs::CompressedImage>();
  cv::imencode(".png", cv::Mat(4, 5, CV_8UC1, cv::Scalar(9)), message->data);
  message->data[18] = 0x70;  // of the width
  message->data[22] = 0x70;
  EXPECT_THAT(ErrorOf([&] { FromCompressedImage(message, kTopic); }),
              AllOf(HasSubstr(kTopic), HasSubstr("28677 x 28676 px")));
}

TEST(ConversionsTest, RefusesImagesOfAnotherSizeAtOnce) {
  const auto raw = MakeImage("mono8", 4, 3, 4);
  EXPECT_NO_THROW(FromImage(raw, kTopic, {4, 3}));
  EXPECT_THAT(ErrorOf([&] {
                FromImage(raw, kTopic, {3, 4});
              }),
              AllOf(HasSubstr(kTopic), HasSubstr("4 x 3"), HasSubstr("expected 3 x 4")));
  const auto jpeg = boost::make_shared<sensor_msgs::CompressedImage>();
  cv::imencode(".jpg", cv::Mat(4, 5, CV_8UC1, cv::Scalar(9)), jpeg->data);
  EXPECT_NO_THROW(FromCompressedImage(jpeg, kTopic, {5, 4}));
  EXPECT_THAT(ErrorOf([&] {
                FromCompressedImage(jpeg, kTopic, {5, 5});
              }),
              AllOf(HasSubstr(kTopic), HasSubstr("5 x 4"), HasSubstr("expected 5 x 5")));
}

TEST(ConversionsTest, ImagesRoundTrip) {
  cv::Mat big(6, 8, CV_8UC1);
  for (int i = 0; i < 48; ++i) {
    big.at<std::uint8_t>(i / 8, i % 8) = static_cast<std::uint8_t>(i);
  }
  const cv::Mat part = big(cv::Rect(1, 1, 4, 3));  // rows are not contiguous
  const auto message = boost::make_shared<sensor_msgs::Image>(ToImage(part, 7, "cam0"));
  EXPECT_EQ(message->header.frame_id, "cam0");
  EXPECT_EQ(ToNanoseconds(message->header.stamp), 7);
  const cv::Mat back = FromImage(message, kTopic)();
  EXPECT_EQ(cv::norm(back, part, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace deja_view
