#include "deja_view/ros/bag/bag_poses.hpp"

#include "bag_fixture.hpp"
#include <gmock/gmock.h>

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>

namespace deja_view {
namespace {

class BagPosesTest : public BagTest {};

TEST_F(BagPosesTest, ReadsEveryKindOfPose) {
  const Rigid3 pose{ExpSo3({0.1, 0.2, 0.3}), {1, 2, 3}};
  {
    BagWriter bag(Path("a.bag"));
    geometry_msgs::PoseStamped stamped;
    stamped.header.stamp = ToRosTime(kStart);
    stamped.pose = ToPose(pose);
    bag.Write("/pose", kStart, stamped);
    geometry_msgs::PoseWithCovarianceStamped covariance;
    covariance.header = stamped.header;
    covariance.pose.pose = stamped.pose;
    bag.Write("/covariance", kStart, covariance);
    geometry_msgs::TransformStamped transform;
    transform.header = stamped.header;
    transform.transform.translation.x = 1;
    transform.transform.translation.y = 2;
    transform.transform.translation.z = 3;
    transform.transform.rotation = stamped.pose.orientation;
    bag.Write("/transform", kStart, transform);
    nav_msgs::Odometry odometry;
    odometry.header = stamped.header;
    odometry.pose.pose = stamped.pose;
    bag.Write("/odometry", kStart, odometry);
    bag.Close();
  }
  const BagReader bag(Path("a.bag"));
  for (const char* topic : {"/pose", "/covariance", "/transform", "/odometry"}) {
    const Trajectory trajectory = ReadBagPoses(bag, topic);
    ASSERT_EQ(trajectory.size(), 1U) << topic;
    EXPECT_EQ(trajectory.stamps_ns[0], kStart);
    EXPECT_EQ(trajectory.poses[0].t, pose.t);
    EXPECT_LT(RotationAngle(trajectory.poses[0].q.conjugate() * pose.q), 1e-12);
  }
}

TEST_F(BagPosesTest, DoubledStampsCountOnceAndOnesThatGoBackAreErrors) {
  {
    BagWriter bag(Path("a.bag"));
    for (const int step : {0, 1, 1, 2}) {
      bag.Write("/good", kStart + step, MakeOdometry(kStart + step, step));
    }
    bag.Write("/image", kStart, MakeImage(kStart, 0));
    bag.Close();
  }
  const BagReader bag(Path("a.bag"));
  EXPECT_EQ(ReadBagPoses(bag, "/good").size(), 3U);
  EXPECT_THAT(ErrorOf([&] {
                BagWriter back(Path("b.bag"));
                back.Write("/bad", kStart, MakeOdometry(kStart + 5, 0));
                back.Write("/bad", kStart + 1, MakeOdometry(kStart, 0));
                back.Close();
                ReadBagPoses(BagReader(Path("b.bag")), "/bad");
              }),
              Says("b.bag", "'/bad'", "comes after"));
  EXPECT_THAT(ErrorOf([&] { ReadBagPoses(bag, "/image"); }), Says("TransformStamped"));
  EXPECT_THAT(ErrorOf([&] { ReadBagPoses(bag, "/none"); }), Says("no topic '/none'"));
}

}  // namespace
}  // namespace deja_view
