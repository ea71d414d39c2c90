#include "deja_view/geometry/trajectory.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(Trajectory, InterpolatesBetweenNeighboursOnly) {
  Trajectory trajectory;
  EXPECT_FALSE(trajectory.At(0).has_value());
  const std::int64_t start = 1403636625838560104;
  trajectory.stamps_ns = {start, start + 4, start + 1000};
  trajectory.poses = {
      {FromYaw(0.0), {0, 0, 0}}, {FromYaw(0.4), {8, 0, 0}}, {FromYaw(0.4), {9, 0, 0}}};
  EXPECT_FALSE(trajectory.At(start - 1).has_value());
  EXPECT_FALSE(trajectory.At(start + 1001).has_value());
  EXPECT_EQ(trajectory.At(start)->t.x(), 0.0);
  EXPECT_EQ(trajectory.At(start + 1000)->t.x(), 9.0);
  EXPECT_NEAR(trajectory.At(start + 1)->t.x(), 2.0, 1e-12);
  EXPECT_NEAR(Yaw(trajectory.At(start + 1)->q), 0.1, 1e-12);
  EXPECT_TRUE(trajectory.At(start + 500).has_value());
  EXPECT_FALSE(trajectory.At(start + 500, 995).has_value());
  EXPECT_TRUE(trajectory.At(start + 500, 996).has_value());
}

}  // namespace
}  // namespace deja_view
