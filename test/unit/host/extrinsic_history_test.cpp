#include "deja_view/host/extrinsic_history.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

Rigid3 Calibration(double x, double yaw_rad = 0) {
  return {FromYaw(yaw_rad), {x, 0, 0}};
}

double PositionAt(const ExtrinsicHistory& history, std::int64_t key) {
  const auto T_B_C = history.At(key);
  return T_B_C ? T_B_C->t.x() : -1;
}

TEST(ExtrinsicHistory, GivesTheNewestUpToATime) {
  ExtrinsicHistory history;
  EXPECT_EQ(PositionAt(history, 100), -1);
  EXPECT_TRUE(history.Add(10, Calibration(0.01)));
  EXPECT_TRUE(history.Add(20, Calibration(0.02)));
  EXPECT_EQ(PositionAt(history, 9), -1);
  EXPECT_EQ(PositionAt(history, 19), 0.01);
  EXPECT_EQ(PositionAt(history, 20), 0.02);
}

TEST(ExtrinsicHistory, FollowsARefinementThatGoesFar) {
  ExtrinsicHistory history;
  for (int i = 0; i <= 100; ++i) {
    EXPECT_TRUE(history.Add(i, Calibration(0.01 * i, 0.01 * i)));
  }
  EXPECT_EQ(PositionAt(history, 100), 1.0);
}

TEST(ExtrinsicHistory, DoesNotBelieveWhatJumps) {
  ExtrinsicHistory history;
  history.Add(0, Calibration(0.1));
  for (int i = 1; i < 200; ++i) {
    if (i % 5 == 0) {
      EXPECT_TRUE(history.Add(i, Calibration(0.1)));
    } else if (i % 2 == 0) {
      EXPECT_FALSE(history.Add(i, Calibration(i)));
    } else {
      EXPECT_FALSE(history.Add(i, Calibration(0.1, 1.5)));
    }
    EXPECT_EQ(PositionAt(history, i), 0.1);
    EXPECT_LT(RotationAngle(history.At(i)->q), 1e-9);
  }
}

TEST(ExtrinsicHistory, BelievesAJumpOnceManyAgree) {
  ExtrinsicHistory history;
  history.Add(0, Calibration(100));
  for (int i = 1; i < ExtrinsicHistory::kConfirmations; ++i) {
    EXPECT_FALSE(history.Add(i, Calibration(0.001 * i)));
  }
  EXPECT_EQ(PositionAt(history, 50), 100);
  EXPECT_TRUE(history.Add(50, Calibration(0.02)));
  EXPECT_EQ(PositionAt(history, 50), 0.02);
  EXPECT_FALSE(history.Add(51, Calibration(100)));
}

}  // namespace
}  // namespace deja_view
