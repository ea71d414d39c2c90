#include "deja_view/ros/messages/output_messages.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "test_cameras.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr std::int64_t kStamp = 1403636627638560123;

std::vector<KeyframeInfo> MakeKeyframes(int count) {
  std::vector<KeyframeInfo> keyframes;
  for (int i = 0; i < count; ++i) {
    KeyframeInfo keyframe;
    keyframe.index = i;
    keyframe.stamp_ns = kStamp + i;
    keyframe.T_W_B.t.x() = i;
    keyframe.T_M_B.t.y() = 10 + i;
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

TEST(OutputMessagesTest, LoopConstraintSaysEverything) {
  LoopReport loop;
  loop.current = 40;
  loop.old = 3;
  loop.stamp_current_ns = kStamp;
  loop.stamp_old_ns = kStamp - 5;
  loop.T_Bold_Bcurrent.t = {1, 2, 3};
  loop.covariance(0, 5) = 0.25;
  loop.score = 0.75;
  loop.matches = 60;
  loop.inliers = 45;
  loop.reason = RejectReason::kGravity;
  LoopConstraint message = ToLoopConstraint(loop, {});
  EXPECT_EQ(ToNanoseconds(message.header.stamp), kStamp);
  EXPECT_EQ(ToNanoseconds(message.stamp_current), kStamp);
  EXPECT_EQ(ToNanoseconds(message.stamp_old), kStamp - 5);
  EXPECT_EQ(message.index_current, 40);
  EXPECT_EQ(message.index_old, 3);
  EXPECT_EQ(message.relative_pose.pose.position.z, 3);
  EXPECT_EQ(message.relative_pose.covariance[5], 0.25);
  EXPECT_EQ(message.score, 0.75);
  EXPECT_EQ(message.matches, 60);
  EXPECT_EQ(message.inliers, 45);
  EXPECT_FALSE(message.accepted);
  EXPECT_EQ(message.reason, EnumToString(RejectReason::kGravity));
  loop.reason = RejectReason::kNone;
  message = ToLoopConstraint(loop, {});
  EXPECT_TRUE(message.accepted);
  EXPECT_EQ(message.reason, "accepted");
}

TEST(OutputMessagesTest, DriftIsTheViosWorldInTheMap) {
  const Rigid3 T_M_W{FromYaw(0.5), {1, 2, 3}};
  const geometry_msgs::TransformStamped message = ToDrift(T_M_W, kStamp, {});
  EXPECT_EQ(message.header.frame_id, "world");
  EXPECT_EQ(message.child_frame_id, "vio");
  EXPECT_EQ(message.transform.translation.y, 2);
  EXPECT_DOUBLE_EQ(message.transform.rotation.z, std::sin(0.25));
}

TEST(OutputMessagesTest, TheCorrectedBodyHasAFrameOfItsOwn) {
  const Rigid3 T_M_B{FromYaw(-0.5), {1, 2, 3}};
  const geometry_msgs::TransformStamped message = ToCorrectedBody(T_M_B, kStamp, {});
  EXPECT_EQ(message.header.stamp, ToRosTime(kStamp));
  EXPECT_EQ(message.header.frame_id, "world");
  EXPECT_EQ(message.child_frame_id, "body_corrected");
  EXPECT_EQ(message.transform.translation.x, 1);
  EXPECT_DOUBLE_EQ(message.transform.rotation.z, -std::sin(0.25));
}

TEST(OutputMessagesTest, CorrectedOdometryMovesPoseAndVelocity) {
  nav_msgs::Odometry odometry;
  odometry.header.stamp = ToRosTime(kStamp);
  odometry.header.frame_id = "world";
  odometry.pose.covariance[7] = 4;
  odometry.twist.twist.linear.x = 1;
  const Rigid3 T_W_B{Eigen::Quaterniond::Identity(), {1, 0, 0}};
  const Rigid3 T_M_W{FromYaw(M_PI / 2), {0, 0, 5}};
  const nav_msgs::Odometry corrected = CorrectOdometry(odometry, {kStamp, T_W_B}, T_M_W, {});
  EXPECT_EQ(corrected.header.stamp, odometry.header.stamp);
  EXPECT_EQ(corrected.child_frame_id, "body");
  EXPECT_NEAR(corrected.pose.pose.position.x, 0, 1e-12);
  EXPECT_NEAR(corrected.pose.pose.position.y, 1, 1e-12);
  EXPECT_NEAR(corrected.pose.pose.position.z, 5, 1e-12);
  EXPECT_NEAR(corrected.twist.twist.linear.y, 1, 1e-12);
  EXPECT_EQ(corrected.pose.covariance[7], 4);
}

TEST(OutputMessagesTest, PathsHaveCorrectedOrReceivedPoses) {
  const auto keyframes = MakeKeyframes(3);
  const nav_msgs::Path corrected = ToPath(keyframes, false, {});
  ASSERT_EQ(corrected.poses.size(), 3U);
  EXPECT_EQ(corrected.poses[2].pose.position.y, 12);
  EXPECT_EQ(ToNanoseconds(corrected.poses[2].header.stamp), kStamp + 2);
  EXPECT_EQ(corrected.header.stamp, corrected.poses[2].header.stamp);
  EXPECT_EQ(ToPath(keyframes, true, {}).poses[2].pose.position.x, 2);
  EXPECT_TRUE(ToPath({}, false, {}).poses.empty());
}

TEST(OutputMessagesTest, PoseGraphMarkersJoinTheEndsOfLoops) {
  LoopReport loop;
  loop.old = 0;
  loop.current = 2;
  LoopReport stray;
  stray.old = 1;
  stray.current = 9;
  const auto markers = ToPoseGraphMarkers(MakeKeyframes(3), {loop, stray}, {});
  ASSERT_EQ(markers.markers.size(), 1U);
  ASSERT_EQ(markers.markers[0].points.size(), 2U);
  EXPECT_EQ(markers.markers[0].points[0].y, 10);
  EXPECT_EQ(markers.markers[0].points[1].y, 12);
  EXPECT_EQ(ToKeyframeMarker(MakeKeyframes(3), {}).points.size(), 3U);
  // Of a thinned list the next keyframe that is in it.
  std::vector<KeyframeInfo> thinned = MakeKeyframes(5);
  thinned.erase(thinned.begin() + 2);
  EXPECT_EQ(ToPoseGraphMarkers(thinned, {loop}, {}).markers[0].points[1].y, 13);
}

TEST(OutputMessagesTest, CameraIsAPyramidInFrontOfItsCentre) {
  const Rigid3 T_M_C{Eigen::Quaterniond::Identity(), {1, 1, 1}};
  const auto markers = ToCameraMarkers(T_M_C, PinholeOf(200, 100, 100, 100, 50), 0.5, kStamp, {});
  ASSERT_EQ(markers.markers.size(), 1U);
  const auto& points = markers.markers[0].points;
  ASSERT_EQ(points.size(), 16U);
  EXPECT_EQ(points[0].z, 1.0);
  EXPECT_EQ(points[1].z, 1.5);
  EXPECT_DOUBLE_EQ(points[1].x, 1 - 0.5);
  EXPECT_DOUBLE_EQ(points[1].y, 1 - 0.25);
}

TEST(OutputMessagesTest, MatchPointsAreWhatVinsMonoReads) {
  Relocalisation relocalisation;
  relocalisation.old = 3;
  relocalisation.T_M_Bold = {FromYaw(0.5), {1, 2, 3}};
  relocalisation.points.push_back({42, {0.25, -0.5}});
  const sensor_msgs::PointCloud message = ToMatchPoints(relocalisation, 17, kStamp, "world");
  EXPECT_EQ(ToNanoseconds(message.header.stamp), kStamp);
  ASSERT_EQ(message.points.size(), 2U);
  EXPECT_EQ(message.points[0].x, 0.25F);
  EXPECT_EQ(message.points[0].y, -0.5F);
  EXPECT_EQ(message.points[0].z, 42.0F);
  ASSERT_EQ(message.channels.size(), 1U);
  const auto& values = message.channels[0].values;
  ASSERT_EQ(values.size(), 8U);
  EXPECT_EQ(values[2], 3.0F);
  EXPECT_FLOAT_EQ(values[3], static_cast<float>(std::cos(0.25)));
  EXPECT_FLOAT_EQ(values[6], static_cast<float>(std::sin(0.25)));
  EXPECT_EQ(values[7], 17.0F);
}

TEST(OutputMessagesTest, MatchPointsAscendAndEndBehindEveryTrack) {
  Relocalisation relocalisation;
  relocalisation.points = {{42, {0.25, -0.5}}, {7, {0.5, 0.125}}, {19, {0, 0}}};
  const sensor_msgs::PointCloud message = ToMatchPoints(relocalisation, 17, kStamp, "world");
  ASSERT_EQ(message.points.size(), 4U);
  EXPECT_EQ(message.points[0].z, 7.0F);
  EXPECT_EQ(message.points[0].x, 0.5F);
  EXPECT_EQ(message.points[1].z, 19.0F);
  EXPECT_EQ(message.points[2].z, 42.0F);
  // VINS-Mono makes an int of it.
  EXPECT_GT(message.points[3].z, 2.1e9F);
  EXPECT_LE(static_cast<double>(message.points[3].z), std::numeric_limits<std::int32_t>::max());
}

}  // namespace
}  // namespace deja_view
