#include "deja_view/ros/bag/keyframe_bag.hpp"

#include "deja_view/ros/bag/bag_images.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"

#include <map>
#include <string>
#include <vector>

#include "bag_fixture.hpp"
#include "synthetic_image.hpp"
#include "test_cameras.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A flight along a painted wall 2 m away that looks at it, 6 px an image.
class KeyframeBagTest : public BagTest {
 protected:
  static constexpr int kSide = 200;
  static constexpr int kImages = 40;
  static constexpr int kStep = 6;
  static constexpr double kWall = 2;  // [m]
  static constexpr double kFocal = 150;

  KeyframeBagTest() {
    job_.bag = Path("flight.bag");
    job_.out = Path("keyframes.bag");
    job_.image_topic = "/camera/image";
    job_.odometry_topic = "/vicon";
    job_.front_end.camera = SharedPinholeOf(kSide, kSide, kFocal, 99.5, 99.5);
    Eigen::Matrix3d R_B_C;  // looks along the body's x axis, z up
    R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    job_.front_end.T_B_C = {Eigen::Quaterniond(R_B_C), {0.1, 0, 0}};
    job_.on_problem = [this](const std::string& what) { problems_.push_back(what); };
  }

  /// `second_step`: the images further on that the second camera is; 0 for none.
  void Write(int second_step = 0) {
    const cv::Mat wall = test::SyntheticImage(kSide + 60 * kStep, kSide, 5);
    BagWriter bag(job_.bag);
    for (int i = 0; i < kImages; ++i) {
      const std::int64_t stamp = kStart + i * 50 * kMillisecond;
      const auto picture = [&](int step) {
        return ToImage(wall(cv::Rect(step * kStep, 0, kSide, kSide)).clone(), stamp, "cam");
      };
      bag.Write(job_.image_topic, stamp + kMillisecond, picture(i));
      if (second_step > 0) {
        bag.Write("/camera/right", stamp + kMillisecond, picture(i + second_step));
      }
      nav_msgs::Odometry pose = MakeOdometry(stamp, 0);
      pose.pose.pose.position.y = -i * kStep * kWall / kFocal;
      bag.Write(job_.odometry_topic, stamp + 30 * kMillisecond, pose);
    }
    bag.Close();
  }

  std::map<std::string, std::int64_t> Topics() const {
    std::map<std::string, std::int64_t> topics;
    const BagReader bag(job_.out);
    for (const BagReader::Topic& topic : bag.topics()) {
      topics[topic.name] = topic.messages;
    }
    return topics;
  }

  KeyframeBagJob job_;
  std::vector<std::string> problems_;
};

TEST_F(KeyframeBagTest, HoldsWhatVinsMonoWouldPublish) {
  Write();
  const FrontEndCounts counts = WriteKeyframeBag(job_);
  EXPECT_EQ(counts.images, kImages);
  EXPECT_EQ(counts.keyframes, kImages / 2);
  EXPECT_THAT(problems_, IsEmpty());
  const std::map<std::string, std::int64_t> expected = {
      {"/camera/image", kImages},
      {"/vins_estimator/odometry", kImages},
      {"/vins_estimator/extrinsic", counts.keyframes},
      {"/vins_estimator/keyframe_pose", counts.keyframes},
      {"/vins_estimator/keyframe_point", counts.keyframes}};
  EXPECT_EQ(Topics(), expected);
  const auto keyframes = ReadBagKeyframes(BagReader(job_.out), {});
  ASSERT_THAT(keyframes, SizeIs(static_cast<std::size_t>(counts.keyframes)));
  for (std::size_t k = 2; k < keyframes.size(); ++k) {
    EXPECT_GT(keyframes[k].points.size(), 10U);
    for (const TrackedPoint& point : keyframes[k].points) {
      EXPECT_NEAR(point.p_W.x(), 0.1 + kWall, 0.1);
      const auto pixel = job_.front_end.camera->Project(keyframes[k].T_W_C.Inverse() * point.p_W);
      EXPECT_LT((*pixel - point.pixel.cast<double>()).norm(), 1.0);
    }
  }
}

TEST_F(KeyframeBagTest, ReplaysAsTheFlightItselfDoes) {
  Write();
  WriteKeyframeBag(job_);
  const auto replayed = [&](const std::filesystem::path& bag, bool makes_keyframes) {
    std::vector<KeyframeInput> keyframes;
    ReplayCallbacks callbacks;
    callbacks.on_keyframe = [&](const KeyframeInput& input) { keyframes.push_back(input); };
    VioTopics topics;
    topics.image = job_.image_topic;
    if (makes_keyframes) {
      topics.odometry = job_.odometry_topic;
    }
    ReplayBag(bag,
              {},
              topics,
              {},
              callbacks,
              makes_keyframes ? std::optional(job_.front_end) : std::nullopt);
    return keyframes;
  };
  const auto expected = replayed(job_.bag, true);
  const auto found = replayed(job_.out, false);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].stamp_ns, expected[k].stamp_ns);
    ASSERT_EQ(found[k].points.size(), expected[k].points.size());
    for (std::size_t i = 0; i < found[k].points.size(); ++i) {
      EXPECT_LT((found[k].points[i].p_W - expected[k].points[i].p_W).norm(), 1e-5);
    }
  }
}

TEST_F(KeyframeBagTest, TakesPointsFromASecondCamera) {
  Write(6);
  job_.front_end.options.window_s = 0.001;  // no image but the keyframe's own
  job_.front_end.options.delay_s = 0;
  EXPECT_EQ(WriteKeyframeBag(job_).points, 0);
  job_.second_image_topic = "/camera/right";
  job_.front_end.second = SecondCamera{job_.front_end.camera, job_.front_end.T_B_C};
  job_.front_end.second->T_B_C.t.y() = -6 * kStep * kWall / kFocal;
  const FrontEndCounts counts = WriteKeyframeBag(job_);
  EXPECT_GT(counts.points, 10 * counts.keyframes);
  EXPECT_EQ(counts.without_points, 0);
}

TEST_F(KeyframeBagTest, NamesWhatTheBagLacks) {
  Write();
  job_.odometry_topic = "/poses";
  EXPECT_THAT(ErrorOf([&] { WriteKeyframeBag(job_); }), HasSubstr("/poses"));
  job_.odometry_topic = "/vicon";
  job_.image_topic = "/vicon";
  EXPECT_THAT(ErrorOf([&] { WriteKeyframeBag(job_); }), HasSubstr("sensor_msgs/Image"));
  job_.out = job_.bag;
  EXPECT_THAT(ErrorOf([&] { WriteKeyframeBag(job_); }), HasSubstr("another bag"));
  EXPECT_FALSE(std::filesystem::exists(Path("keyframes.bag")));
}

}  // namespace
}  // namespace deja_view
