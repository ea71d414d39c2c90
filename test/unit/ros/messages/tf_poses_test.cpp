#include "deja_view/ros/messages/tf_poses.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kStart_ns = 1'400'000'000'000'000'000;

tf2_msgs::TFMessage Link(const std::string& parent,
                         const std::string& child,
                         double seconds,
                         const Eigen::Vector3d& t) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = parent;
  transform.header.stamp = ToRosTime(kStart_ns + std::llround(1e9 * seconds));
  transform.child_frame_id = child;
  transform.transform.translation.x = t.x();
  transform.transform.translation.y = t.y();
  transform.transform.translation.z = t.z();
  transform.transform.rotation.w = 1;
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  return message;
}

double SecondsOf(const StampedPose& pose) {
  return 1e-9 * static_cast<double>(pose.stamp_ns - kStart_ns);
}

TEST(ParseTfFrames, OfAPairAndOfATopic) {
  const auto frames = ParseTfFrames("tf:/world,drone/base_link");
  ASSERT_TRUE(frames);
  EXPECT_EQ(frames->world, "world");
  EXPECT_EQ(frames->body, "drone/base_link");
  EXPECT_FALSE(ParseTfFrames("/tf"));
  EXPECT_FALSE(ParseTfFrames("/odometry"));
}

TEST(ParseTfFrames, RefusesOtherThanTwoFrames) {
  for (const char* text : {"tf:", "tf:world", "tf:world,", "tf:,body", "tf:a,b,c", "tf:/,b"}) {
    EXPECT_THROW(ParseTfFrames(text), InputError) << text;
  }
}

TEST(TfPoses, GiveEachPoseOfALinkOnce) {
  TfPoses poses({"world", "body"});
  const auto first = poses.Add(Link("/world", "body", 0.1, {1, 2, 3}));
  ASSERT_TRUE(first);
  EXPECT_NEAR(SecondsOf(*first), 0.1, 1e-9);
  EXPECT_EQ(first->pose.t, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(poses.Add(Link("world", "body", 0.1, {1, 2, 3})));
  EXPECT_FALSE(poses.Add(Link("world", "camera", 0.2, {0, 0, 0})));
  EXPECT_TRUE(poses.Add(Link("world", "body", 0.2, {1, 2, 3})));
}

TEST(TfPoses, GoThroughFramesBetweenAndInterpolateTheSlowerOne) {
  TfPoses poses({"map", "camera"});
  poses.AddStatic(Link("body", "camera", 0, {0, 0, 0.1}));
  EXPECT_FALSE(poses.Add(Link("map", "odom", 0, {0, 0, 0})));
  EXPECT_TRUE(poses.Add(Link("odom", "body", 0, {5, 0, 0})));
  EXPECT_FALSE(poses.Add(Link("odom", "body", 0.5, {6, 0, 0})));
  const auto pose = poses.Add(Link("map", "odom", 1.0, {0, 2, 0}));
  ASSERT_TRUE(pose);
  EXPECT_NEAR(SecondsOf(*pose), 0.5, 1e-9);
  EXPECT_NEAR((pose->pose.t - Eigen::Vector3d(6, 1, 0.1)).norm(), 0, 1e-9);
}

TEST(TfPoses, BeginAnewWhereStampsGoBack) {
  TfPoses poses({"world", "camera"});
  poses.AddStatic(Link("body", "camera", 0, {0, 0, 0.1}));
  EXPECT_TRUE(poses.Add(Link("world", "body", 100, {0, 0, 0})));
  const auto again = poses.Add(Link("world", "body", 1, {1, 0, 0}));
  ASSERT_TRUE(again);
  EXPECT_NEAR(again->pose.t.x(), 1, 1e-9);
}

TEST(TfPoses, RefuseABrokenTransformAndGoOn) {
  TfPoses poses({"world", "body"});
  tf2_msgs::TFMessage broken = Link("world", "body", 0.1, {1, 2, 3});
  broken.transforms[0].transform.rotation.w = 0;
  EXPECT_THROW(poses.Add(broken), InputError);
  EXPECT_TRUE(poses.Add(Link("world", "body", 0.2, {1, 2, 3})));
}

TEST(TfPoses, DescribeWhatThereIs) {
  TfPoses poses({"world", "body"});
  EXPECT_THAT(poses.Describe(), HasSubstr("there are none"));
  poses.Add(Link("odom", "base_link", 0.1, {1, 2, 3}));
  EXPECT_THAT(poses.Describe(),
              HasSubstr("no transform from world to body; there are odom -> base_link"));
}

}  // namespace
}  // namespace deja_view
