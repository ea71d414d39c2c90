#include "deja_view/host/restart_detector.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

// Keyframes of a camera that flies along x past points of a wall at y = 5 m, in a VIO's world.
class RestartDetectorTest : public testing::Test {
 protected:
  static Rigid3 At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 1}}; }

  // The points of ids [first, first + 30), seen at `s` seconds from x metres of the true world.
  bool Add(double s, double x, int first, const Rigid3& T_W_true = {}) {
    std::vector<TrackedPoint> points;
    for (int id = first; id < first + 30; ++id) {
      TrackedPoint point;
      point.feature_id = id;
      const Eigen::Vector3d noise(noise_(random_), noise_(random_), noise_(random_));
      point.p_W = T_W_true * (Eigen::Vector3d(0.1 * id, 5, id % 5) + noise);
      points.push_back(point);
    }
    return detector_.Add(std::llround(1e9 * s), T_W_true * At(x), points);
  }

  const Rigid3 other_world_{Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ())),
                            {3, -1, 0}};
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0, 0.1};
  RestartDetector detector_;
};

TEST_F(RestartDetectorTest, AFlightIsNone) {
  for (int i = 0; i < 40; ++i) {
    EXPECT_FALSE(Add(0.2 * i, 0.4 * i, 2 * i)) << i;
  }
}

TEST_F(RestartDetectorTest, APauseWithTheSameTracksIsNone) {
  Add(0, 0, 0);
  EXPECT_FALSE(Add(8, 0.1, 5));
}

TEST_F(RestartDetectorTest, TracksThatAllMoveTellOfAnotherWorld) {
  Add(0, 0, 0);
  Add(0.2, 0.1, 0);
  EXPECT_TRUE(Add(0.6, 0.3, 5, other_world_));
  EXPECT_FALSE(Add(0.8, 0.4, 5, other_world_));
}

TEST_F(RestartDetectorTest, AFewBadPointsDoNot) {
  Add(0, 0, 0);
  std::vector<TrackedPoint> points(20);
  for (std::size_t id = 0; id < 20; ++id) {
    const double y = id < 9 ? 50 : 5;
    points[id].feature_id = static_cast<std::int64_t>(id);
    points[id].p_W = {0.1 * static_cast<double>(id), y, static_cast<double>(id % 5)};
  }
  EXPECT_FALSE(detector_.Add(200000000, At(0.1), points));
}

TEST_F(RestartDetectorTest, AVioThatFindsItsScaleIsNone) {
  const auto add = [this](double s, double scale) {
    std::vector<TrackedPoint> points(20);
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].feature_id = static_cast<std::int64_t>(i);
      points[i].p_W = scale * Eigen::Vector3d(8, static_cast<double>(i), 1);
    }
    return detector_.Add(std::llround(1e9 * s), At(0.2 * s), points);
  };
  add(0, 6);
  EXPECT_FALSE(add(0.1, 1));
  EXPECT_FALSE(add(0.2, 0.9));
}

TEST_F(RestartDetectorTest, NewTracksWithoutASilenceAreNone) {
  Add(0, 0, 0);
  Add(0.2, 0.1, 0);
  EXPECT_FALSE(Add(1.1, 0.6, 100));
}

// As VINS-Mono, whose new world begins where it is, not where it was.
TEST_F(RestartDetectorTest, NewTracksAfterASilenceAreOneEvenNearby) {
  Add(0, 0, 0);
  Add(0.2, 0.1, 0);
  EXPECT_TRUE(Add(1.6, 0.9, 100));
  EXPECT_FALSE(Add(1.8, 1.0, 102));
}

// A front end that has just begun to follow corners has no points yet.
TEST_F(RestartDetectorTest, HowLongASilenceMayBeIsAnOption) {
  detector_ = RestartDetector(20);
  Add(0, 0, 0);
  Add(1.4, 0.1, 0);
  EXPECT_FALSE(Add(2.8, 0.2, 100));
}

TEST_F(RestartDetectorTest, NoPointsAfterASilenceAreOne) {
  Add(0, 0, 0);
  Add(0.2, 0.1, 0);
  EXPECT_FALSE(detector_.Add(400000000, At(0.2), {}));
  Add(0.6, 0.3, 0);
  Add(0.8, 0.4, 0);
  EXPECT_TRUE(detector_.Add(1900000000, At(0.9), {}));
}

TEST_F(RestartDetectorTest, NewTracksInAFastTurnAreNone) {
  Add(0, 0, 0);
  Add(0.2, 0.4, 0);
  EXPECT_FALSE(Add(0.5, 1.0, 100));
}

TEST_F(RestartDetectorTest, NewTracksWhereTheMotionCouldNotLeadAreOne) {
  Add(0, 0, 0);
  Add(0.2, 0.4, 0);
  EXPECT_TRUE(Add(0.5, -3, 100));
}

TEST_F(RestartDetectorTest, NewTracksAfterASilenceAreOneWhereTheyAreFarOff) {
  Add(0, 0, 0);
  Add(0.2, 0.1, 0);
  EXPECT_TRUE(Add(1.7, 7.0, 100));
}

TEST_F(RestartDetectorTest, NamesThatNeverComeAgainTellNothing) {
  Add(0, 0, 0);
  Add(0.2, 0.4, 100);
  EXPECT_FALSE(Add(0.5, -3, 200));
  EXPECT_FALSE(Add(9, -3, 300));
}

TEST_F(RestartDetectorTest, NothingIsKnownWithoutPointsOrAfterAReset) {
  Add(0, 0, 0);
  EXPECT_FALSE(detector_.Add(5000000000, other_world_, {}));
  Add(6, 0, 0);
  detector_.Reset();
  EXPECT_FALSE(Add(6.2, 0.3, 5, other_world_));
}

}  // namespace
}  // namespace deja_view
