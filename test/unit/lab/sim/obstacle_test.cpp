#include "deja_view/lab/sim/obstacle.hpp"

#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

TEST(Obstacle, DistanceToABoxInClosedForm) {
  Obstacle box;
  box.centre = {1, 2, 0.5};
  box.half_size = {1, 0.5, 0.5};
  box.yaw = 1.5707963267948966;  // x and y half sizes change places
  EXPECT_NEAR(box.Distance({3, 2, 0.5}), 1.5, 1e-12);
  EXPECT_NEAR(box.Distance({1, 4, 0.5}), 1.0, 1e-12);
  EXPECT_NEAR(box.Distance({1.5 + 3, 2, 1 + 4}), 5.0, 1e-12);
  EXPECT_NEAR(box.Distance({1, 2, 0.5}), -0.5, 1e-12);
}

TEST(Obstacle, DistanceToACylinderInClosedForm) {
  Obstacle drum;
  drum.half_size = {0.5, 0.5, 1};
  drum.is_cylinder = true;
  EXPECT_NEAR(drum.Distance({3, 4, 0}), 4.5, 1e-12);
  EXPECT_NEAR(drum.Distance({0, 0, 3}), 2.0, 1e-12);
  EXPECT_NEAR(drum.Distance({3.5, 0, 5}), 5.0, 1e-12);
  EXPECT_NEAR(drum.Distance({0.2, 0, 0}), -0.3, 1e-12);
}

}  // namespace
}  // namespace deja_view::sim
