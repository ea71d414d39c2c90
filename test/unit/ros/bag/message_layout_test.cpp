#include "message_layout.hpp"

#include "deja_view/VirtualFrame.h"

#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/serialization.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud.h>
#include <std_msgs/String.h>

namespace deja_view::internal {
namespace {

template <typename Message>
MessageLayout LayoutOf() {
  return {ros::message_traits::datatype<Message>(), ros::message_traits::definition<Message>()};
}

template <typename Message>
std::vector<std::uint8_t> Bytes(const Message& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

// Needs every byte: one less is an overrun.
template <typename Message>
void ExpectExact(const Message& message) {
  const MessageLayout layout = LayoutOf<Message>();
  const std::vector<std::uint8_t> bytes = Bytes(message);
  EXPECT_EQ(layout.FindOverrun(bytes.data(), bytes.size()), "");
  EXPECT_NE(layout.FindOverrun(bytes.data(), bytes.size() - 1), "");
  EXPECT_NE(layout.FindOverrun(bytes.data(), 0), "");
}

sensor_msgs::PointCloud Points() {
  sensor_msgs::PointCloud message;
  message.header.frame_id = "world";
  message.points.resize(3);
  message.channels.resize(2);
  message.channels[0].name = "id";
  message.channels[1].values = {1, 2, 3};
  return message;
}

TEST(MessageLayout, KnowsWhereEachMessageEnds) {
  sensor_msgs::Image image;
  image.encoding = "mono8";
  image.data.resize(7);
  ExpectExact(image);
  ExpectExact(Points());
  nav_msgs::Odometry odometry;
  odometry.child_frame_id = "body";
  ExpectExact(odometry);
  VirtualFrame frame;
  frame.distortion = {1, 2, 3, 4};
  frame.camera_model = "PINHOLE";
  frame.depth_sigma.resize(5);
  ExpectExact(frame);
  ExpectExact(sensor_msgs::CompressedImage());
  ExpectExact(geometry_msgs::TransformStamped());
  ExpectExact(std_msgs::String());
}

TEST(MessageLayout, NamesTheFieldThatSaysTooMuch) {
  std::vector<std::uint8_t> bytes = Bytes(Points());
  const std::uint32_t much = 0xFFFFFFF0;
  std::memcpy(&bytes[bytes.size() - 16], &much, 4);
  EXPECT_EQ(LayoutOf<sensor_msgs::PointCloud>().FindOverrun(bytes.data(), bytes.size()),
            "channels.values");
  bytes = Bytes(Points());
  std::memcpy(&bytes[12], &much, 4);
  EXPECT_EQ(LayoutOf<sensor_msgs::PointCloud>().FindOverrun(bytes.data(), bytes.size()),
            "header.frame_id");
  bytes = Bytes(Points());
  std::memcpy(&bytes[21], &much, 4);
  EXPECT_EQ(LayoutOf<sensor_msgs::PointCloud>().FindOverrun(bytes.data(), bytes.size()), "points");
}

}  // namespace
}  // namespace deja_view::internal
