#include "deja_view/base/angles.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(AnglesTest, ConvertsThereAndBack) {
  EXPECT_DOUBLE_EQ(ToRadians(180), std::acos(-1.0));
  EXPECT_DOUBLE_EQ(ToDegrees(std::asin(1.0)), 90);
  EXPECT_DOUBLE_EQ(90 * kDegree, kPi / 2);
}

}  // namespace
}  // namespace deja_view
