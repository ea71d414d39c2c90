#include "deja_view/host/odometry_check.hpp"

#include <cmath>

#include "test_cameras.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

// Looks along the body's x axis, z up.
Rigid3 LevelCamera(double yaw, double roll = 0) {
  Eigen::Matrix3d R_B_C;
  R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Rigid3 T_W_C;
  T_W_C.q = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()) * Eigen::Quaterniond(R_B_C);
  return T_W_C;
}

TEST(MeasureMotion, CountsMetresAndSpeeds) {
  std::vector<Rigid3> poses(4);
  poses[1].t.x() = 1;
  poses[2].t = {1, 2, 0};
  poses[3].t = {1, 2, 4};
  const MotionFigures figures = MeasureMotion({0, 1000000000, 2000000000, 3000000000}, poses);
  EXPECT_DOUBLE_EQ(figures.path_m, 7);
  EXPECT_DOUBLE_EQ(figures.median_mps, 2);
  EXPECT_DOUBLE_EQ(figures.max_mps, 4);
  EXPECT_EQ(MeasureMotion({}, {}).path_m, 0);
}

TEST(UpFromLevelRows, FindsUpOfACameraThatTurns) {
  std::vector<Rigid3> poses;
  poses.reserve(40);
  for (int i = 0; i < 40; ++i) {
    poses.push_back(LevelCamera(0.05 * i, i % 2 == 0 ? 0.1 : -0.1));
  }
  const auto up = UpFromLevelRows(poses);
  ASSERT_TRUE(up);
  EXPECT_GT(std::abs(up->z()), std::cos(0.03));
  // The same flight in a world that lies on its side.
  const Eigen::Quaterniond side(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  for (Rigid3& pose : poses) {
    pose.q = side * pose.q;
  }
  EXPECT_GT(std::abs(UpFromLevelRows(poses)->y()), std::cos(0.03));
}

TEST(UpFromLevelRows, SaysNothingWhereNothingTurned) {
  EXPECT_FALSE(UpFromLevelRows({}));
  EXPECT_FALSE(UpFromLevelRows(std::vector<Rigid3>(20, LevelCamera(0.3))));
  std::vector<Rigid3> tumbling;
  tumbling.reserve(200);
  for (int i = 0; i < 200; ++i) {
    tumbling.push_back(LevelCamera(0.7 * i, 1.1 * i));
  }
  EXPECT_FALSE(UpFromLevelRows(tumbling));
}

TEST(MedianReprojection, IsTheDistanceFromThePointsOwnPixels) {
  const PinholeCamera camera = PinholeOf(640, 480, 400, 320, 240);
  std::vector<TrackedPoint> points(3);
  for (int i = 0; i < 3; ++i) {
    points[i].p_W = {0, 0, 4};
    points[i].pixel = {320.0F + static_cast<float>(i), 240};
  }
  EXPECT_DOUBLE_EQ(*MedianReprojection(Rigid3(), points, camera), 1.0);
  points[0].p_W.z() = points[1].p_W.z() = points[2].p_W.z() = -4;
  EXPECT_FALSE(MedianReprojection(Rigid3(), points, camera));
}

}  // namespace
}  // namespace deja_view
