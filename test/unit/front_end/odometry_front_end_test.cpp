#include "deja_view/front_end/odometry_front_end.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/host/restart_detector.hpp"

#include <cmath>

#include "synthetic_image.hpp"
#include "test_cameras.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kFocal = 200;
constexpr double kDistance = 3;             // of the wall [m]
constexpr int kStep = 4;                    // [px] that the wall moves from image to image
constexpr std::int64_t kPeriod = 50000000;  // of images and poses [ns]
constexpr std::int64_t kStart = 1403636627638560000;

/// A flight along a painted wall, 4 px an image.
class OdometryFrontEndTest : public ::testing::Test {
 protected:
  OdometryFrontEndTest() {
    setup_.camera = SharedPinholeOf(kWidth, kHeight, kFocal, 159.5, 119.5);
    Eigen::Matrix3d R_B_C;  // looks along the body's x axis, z up
    R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    setup_.T_B_C.q = Eigen::Quaterniond(R_B_C);
    setup_.T_B_C.t = Eigen::Vector3d(0.1, 0.02, -0.03);
  }

  OdometryFrontEnd Make() {
    keyframes_.clear();
    problems_.clear();
    return {setup_,
            [this](OdometryFrontEnd::Keyframe k) { keyframes_.push_back(std::move(k)); },
            [this](const std::string& what) { problems_.push_back(what); }};
  }

  static std::int64_t Stamp(int i) { return kStart + i * kPeriod; }

  static Rigid3 Pose(double i) {
    Rigid3 T_W_B;
    T_W_B.t.y() = -i * kStep * kDistance / kFocal;
    return T_W_B;
  }

  cv::Mat Picture(int i) const { return wall_(cv::Rect(i * kStep, 0, kWidth, kHeight)).clone(); }

  void AddImage(OdometryFrontEnd* front_end, int i) const {
    front_end->AddImage(
        Stamp(i), [this, i] { return Picture(i); }, static_cast<std::size_t>(kWidth) * kHeight);
  }

  static void AddPose(OdometryFrontEnd* front_end, int i) { front_end->AddPose(Stamp(i), Pose(i)); }

  void Fly(OdometryFrontEnd* front_end, int begin, int end) const {
    for (int i = begin; i < end; ++i) {
      AddImage(front_end, i);
      AddPose(front_end, i);
    }
  }

  FrontEndSetup setup_;
  std::vector<OdometryFrontEnd::Keyframe> keyframes_;
  std::vector<std::string> problems_;

 private:
  cv::Mat wall_ = test::SyntheticImage(4 * kWidth, kHeight, 5);
};

TEST_F(OdometryFrontEndTest, PutsPointsOnTheWall) {
  OdometryFrontEnd front_end = Make();
  Fly(&front_end, 0, 60);
  front_end.Flush();
  // 10 px of motion are three images.
  EXPECT_EQ(keyframes_.size(), 20U);
  const double wall_x = 0.1 + kDistance;
  for (std::size_t k = 5; k < keyframes_.size(); ++k) {
    const OdometryFrontEnd::Keyframe& keyframe = keyframes_[k];
    EXPECT_GT(keyframe.points.size(), 40U);
    const Rigid3 T_C_W = (keyframe.T_W_B * setup_.T_B_C).Inverse();
    for (const TrackedPoint& point : keyframe.points) {
      EXPECT_NEAR(point.p_W.x(), wall_x, 0.15);
      const auto pixel = setup_.camera->Project(T_C_W * point.p_W);
      EXPECT_LT((*pixel - point.pixel.cast<double>()).norm(), 2.0);
    }
  }
  EXPECT_EQ(front_end.counts().images, 60);
  EXPECT_EQ(front_end.counts().keyframes, 20);
  EXPECT_TRUE(problems_.empty());
}

TEST_F(OdometryFrontEndTest, ComesOutTheSameHoweverTheTopicsInterleave) {
  OdometryFrontEnd in_turn = Make();
  Fly(&in_turn, 0, 40);
  in_turn.Flush();
  const auto expected = keyframes_;
  OdometryFrontEnd images_first = Make();
  for (int i = 0; i < 40; ++i) {
    AddImage(&images_first, i);
  }
  for (int i = 0; i < 40; ++i) {
    AddPose(&images_first, i);
  }
  images_first.Flush();
  ASSERT_EQ(keyframes_.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(keyframes_[k].stamp_ns, expected[k].stamp_ns);
    ASSERT_EQ(keyframes_[k].points.size(), expected[k].points.size());
    for (std::size_t i = 0; i < expected[k].points.size(); ++i) {
      EXPECT_EQ(keyframes_[k].points[i].p_W, expected[k].points[i].p_W);
      EXPECT_EQ(keyframes_[k].points[i].feature_id, expected[k].points[i].feature_id);
    }
  }
}

TEST_F(OdometryFrontEndTest, InterpolatesPosesAtOtherStamps) {
  OdometryFrontEnd front_end = Make();
  for (int i = 0; i < 30; ++i) {
    front_end.AddPose(Stamp(i) - kPeriod / 4, Pose(i - 0.25));
    AddImage(&front_end, i);
  }
  front_end.Flush();
  ASSERT_GT(keyframes_.size(), 5U);
  for (const OdometryFrontEnd::Keyframe& keyframe : keyframes_) {
    const auto i = static_cast<double>(keyframe.stamp_ns - kStart) / kPeriod;
    EXPECT_LT((keyframe.T_W_B.t - Pose(i).t).norm(), 1e-9);
  }
  // The last image has no pose after it.
  EXPECT_EQ(front_end.counts().without_pose, 1);
}

TEST_F(OdometryFrontEndTest, LeavesOutImagesWithoutAPose) {
  OdometryFrontEnd front_end = Make();
  for (int i = 0; i < 30; ++i) {
    AddImage(&front_end, i);
    if (i >= 5 && (i < 10 || i >= 18)) {
      AddPose(&front_end, i);
    }
  }
  front_end.Flush();
  EXPECT_EQ(front_end.counts().without_pose, 5 + 8);
}

TEST_F(OdometryFrontEndTest, StandingStillGivesNoKeyframes) {
  OdometryFrontEnd front_end = Make();
  for (int i = 0; i < 40; ++i) {
    front_end.AddImage(
        Stamp(i), [this] { return Picture(3); }, 1);
    front_end.AddPose(Stamp(i), Pose(3));
  }
  front_end.Flush();
  EXPECT_EQ(keyframes_.size(), 1U);
  EXPECT_TRUE(keyframes_.front().points.empty());
}

TEST_F(OdometryFrontEndTest, FollowsNothingAcrossAPause) {
  OdometryFrontEnd front_end = Make();
  Fly(&front_end, 0, 20);
  const std::size_t before = keyframes_.size();
  for (int i = 20; i < 40; ++i) {
    const std::int64_t stamp_ns = Stamp(i) + 5000000000;
    front_end.AddImage(
        stamp_ns, [this, i] { return Picture(i); }, 1);
    front_end.AddPose(stamp_ns, Pose(i));
  }
  front_end.Flush();
  ASSERT_GT(before, 3U);
  std::int64_t last_id = -1;
  for (const OdometryFrontEnd::Keyframe& keyframe : keyframes_) {
    for (const TrackedPoint& point : keyframe.points) {
      if (keyframe.stamp_ns < Stamp(20)) {
        last_id = std::max(last_id, point.feature_id);
      } else {
        EXPECT_GT(point.feature_id, last_id);
      }
    }
  }
}

// As of an odometry that finds its scale, or jumps to where it was before.
TEST_F(OdometryFrontEndTest, AStepThatNobodyFliesIsANewStart) {
  OdometryFrontEnd front_end = Make();
  Fly(&front_end, 0, 30);
  for (int i = 30; i < 60; ++i) {
    AddImage(&front_end, i);
    Rigid3 T_W_B = Pose(i);
    T_W_B.t.z() += 2;
    front_end.AddPose(Stamp(i), T_W_B);
  }
  front_end.Flush();
  RestartDetector detector;
  std::vector<std::int64_t> restarts;
  for (const OdometryFrontEnd::Keyframe& keyframe : keyframes_) {
    if (detector.Add(keyframe.stamp_ns, keyframe.T_W_B, keyframe.points)) {
      restarts.push_back(keyframe.stamp_ns);
    }
    for (const TrackedPoint& point : keyframe.points) {
      EXPECT_NEAR(point.p_W.x(), 0.1 + kDistance, 0.3);
    }
  }
  EXPECT_EQ(restarts, std::vector<std::int64_t>{Stamp(30)});
}

TEST_F(OdometryFrontEndTest, TellsOfBadImagesAndGoesOn) {
  OdometryFrontEnd front_end = Make();
  Fly(&front_end, 0, 10);
  front_end.AddImage(
      Stamp(10), [] { return cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)); }, 100);
  AddPose(&front_end, 10);
  front_end.AddImage(
      Stamp(11), []() -> cv::Mat { ThrowInputError("can't be decoded"); }, 100);
  AddPose(&front_end, 11);
  AddImage(&front_end, 5);
  Fly(&front_end, 12, 20);
  front_end.Flush();
  EXPECT_EQ(front_end.counts().bad_images, 2);
  EXPECT_EQ(front_end.counts().stray_stamps, 1);
  ASSERT_EQ(problems_.size(), 3U);
  EXPECT_EQ(problems_[0].find("image of stamp"), 0U);
  EXPECT_GE(keyframes_.back().stamp_ns, Stamp(17));
}

TEST_F(OdometryFrontEndTest, StampsThatGoBackTwiceAreANewStart) {
  OdometryFrontEnd front_end = Make();
  Fly(&front_end, 30, 50);
  front_end.AddPose(Stamp(10), Pose(10));  // a stray one
  Fly(&front_end, 50, 55);
  EXPECT_TRUE(problems_.empty());
  AddPose(&front_end, 0);
  AddPose(&front_end, 1);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_NE(problems_[0].find("started anew"), std::string::npos);
  const std::size_t before = keyframes_.size();
  Fly(&front_end, 2, 20);
  front_end.Flush();
  EXPECT_GT(keyframes_.size(), before + 3);
  EXPECT_LT(keyframes_.back().stamp_ns, Stamp(20));
}

TEST_F(OdometryFrontEndTest, AnImageOfTheFutureHoldsUpNothing) {
  OdometryFrontEnd front_end = Make();
  Fly(&front_end, 0, 10);
  front_end.AddImage(
      Stamp(1000000), [this] { return Picture(0); }, 1);
  Fly(&front_end, 10, 30);
  front_end.Flush();
  EXPECT_GE(keyframes_.back().stamp_ns, Stamp(27));
}

TEST_F(OdometryFrontEndTest, HoldsNoMoreImagesThanItMay) {
  setup_.options.image_memory_mb = 1;
  OdometryFrontEnd front_end = Make();
  for (int i = 0; i < 30; ++i) {
    AddImage(&front_end, i);  // 77 kB each, and no odometry
  }
  EXPECT_EQ(front_end.counts().overflows, 30 - 13);
  EXPECT_EQ(problems_.size(), 17U);
}

TEST_F(OdometryFrontEndTest, NamesBadOptions) {
  setup_.options.delay_s = -1;
  setup_.options.tracker.max_corners = 0;
  try {
    Make();
    FAIL();
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("delay_s"), std::string::npos);
    EXPECT_NE(what.find("tracker.max_corners"), std::string::npos);
  }
}

/// With a second camera 0.3 m to the right, which sees the wall 20 px further on.
class StereoFrontEndTest : public OdometryFrontEndTest {
 protected:
  static constexpr double kBaseline = 0.3;
  static constexpr int kDisparity = 20;

  StereoFrontEndTest() {
    setup_.second = SecondCamera{setup_.camera, setup_.T_B_C};
    setup_.second->T_B_C.t.y() -= kBaseline;
  }

  void AddSecondImage(OdometryFrontEnd* front_end, int i) const {
    front_end->AddSecondImage(
        Stamp(i) + 1000,
        [this, i] { return Picture(i + kDisparity / kStep); },
        static_cast<std::size_t>(kWidth) * kHeight);
  }
};

TEST_F(StereoFrontEndTest, GivesPointsToImagesFarApart) {
  OdometryFrontEnd front_end = Make();
  const Rigid3 T_N_W{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())),
                     Eigen::Vector3d(1, 2, 3)};
  AddSecondImage(&front_end, -1);  // of no image
  for (const int i : {0, 40, 80}) {
    AddImage(&front_end, i);
    front_end.AddPose(Stamp(i), T_N_W * Pose(i));
    AddSecondImage(&front_end, i);
  }
  front_end.Flush();
  ASSERT_EQ(keyframes_.size(), 3U);
  for (const OdometryFrontEnd::Keyframe& keyframe : keyframes_) {
    EXPECT_GT(keyframe.points.size(), 40U);
    for (const TrackedPoint& point : keyframe.points) {
      EXPECT_NEAR((T_N_W.Inverse() * point.p_W).x(), 0.1 + kDistance, 0.1);
    }
  }
  EXPECT_EQ(front_end.counts().without_points, 0);
}

TEST_F(StereoFrontEndTest, WaitsForTheSecondImageAndCountsKeyframesWithoutPoints) {
  OdometryFrontEnd front_end = Make();
  for (const int i : {0, 40, 80}) {
    AddPose(&front_end, i);
    AddImage(&front_end, i);
  }
  EXPECT_TRUE(keyframes_.empty());
  AddSecondImage(&front_end, 0);
  AddSecondImage(&front_end, 80);
  front_end.Flush();
  ASSERT_EQ(keyframes_.size(), 3U);
  EXPECT_GT(keyframes_[0].points.size(), 40U);
  EXPECT_TRUE(keyframes_[1].points.empty());
  EXPECT_GT(keyframes_[2].points.size(), 40U);
  EXPECT_EQ(front_end.counts().without_points, 1);
}

TEST_F(StereoFrontEndTest, GoesOnWithoutAnImageOfAnotherSize) {
  OdometryFrontEnd front_end = Make();
  AddPose(&front_end, 0);
  AddImage(&front_end, 0);
  front_end.AddSecondImage(
      Stamp(0), [] { return cv::Mat(10, 12, CV_8UC1, cv::Scalar(0)); }, 120);
  front_end.Flush();
  EXPECT_EQ(keyframes_.size(), 1U);
  EXPECT_EQ(front_end.counts().bad_images, 1);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_NE(problems_[0].find("12 x 10 px"), std::string::npos) << problems_[0];
}

TEST_F(OdometryFrontEndTest, LevelsPosesAndPointsOfKeyframesThatWaited) {
  const auto fly = [this](const Rigid3& T_N_W, GravityPolicy gravity) {
    setup_.gravity = gravity;
    OdometryFrontEnd front_end = Make();
    for (int i = 0; i < 200; ++i) {
      Rigid3 turn;  // once the wall has been passed, so that the level is told
      turn.q = Eigen::AngleAxisd(i < 100 ? 0 : 2 * std::sin(0.1 * i), Eigen::Vector3d::UnitZ());
      AddImage(&front_end, i);
      front_end.AddPose(Stamp(i), T_N_W * turn * Pose(i));
    }
    front_end.Flush();
    return keyframes_;
  };
  const auto expected = fly(Rigid3::Identity(), GravityPolicy::kGiven);
  Rigid3 on_its_side;
  on_its_side.q = Eigen::AngleAxisd(1.5, Eigen::Vector3d(0.6, 0.8, 0));
  const auto found = fly(on_its_side, GravityPolicy::kEstimate);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < 20; ++k) {
    const Rigid3 T_B_W = found[k].T_W_B.Inverse();
    EXPECT_NEAR((found[k].T_W_B.q * Eigen::Vector3d::UnitZ()).z(), 1, 1e-6);
    ASSERT_EQ(found[k].points.size(), expected[k].points.size());
    for (std::size_t i = 0; i < found[k].points.size(); ++i) {
      const Eigen::Vector3d p_B = expected[k].T_W_B.Inverse() * expected[k].points[i].p_W;
      EXPECT_LT((T_B_W * found[k].points[i].p_W - p_B).norm(), 1e-6);
    }
  }
}

TEST_F(OdometryFrontEndTest, GivesUpKeyframesOfAWorldThatCannotBeLevelled) {
  setup_.gravity = GravityPolicy::kEstimate;
  OdometryFrontEnd front_end = Make();
  Fly(&front_end, 0, 60);
  front_end.Flush();
  EXPECT_TRUE(keyframes_.empty());
  EXPECT_EQ(front_end.counts().keyframes, 0);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_NE(problems_[0].find("turned too little"), std::string::npos) << problems_[0];
}

}  // namespace
}  // namespace deja_view
