#include "deja_view/ros/bag/bag_replay.hpp"

#include "deja_view/VirtualFrame.h"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/view_bag.hpp"

#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "bag_fixture.hpp"
#include "test_cameras.hpp"
#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include <std_msgs/String.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class BagReplayTest : public BagTest {
 protected:
  ReplayReport Run(const fs::path& path) { return ReplayBag(path, topics_, {}, Callbacks()); }

  ReplayCallbacks Callbacks() {
    keyframes_.clear();
    problems_.clear();
    calibrations_.clear();
    odometry_ = 0;
    ReplayCallbacks callbacks;
    callbacks.on_keyframe = [this](const KeyframeInput& input) { keyframes_.push_back(input); };
    callbacks.on_extrinsic = [this](const Rigid3& T_B_C) {
      calibrations_.emplace_back(keyframes_.size(), T_B_C.t.x());
    };
    callbacks.on_odometry = [this](const StampedPose&) { ++odometry_; };
    callbacks.on_problem = [this](const std::string& what) { problems_.push_back(what); };
    return callbacks;
  }

  VioTopics topics_;
  std::vector<KeyframeInput> keyframes_;
  std::vector<std::pair<std::size_t, double>> calibrations_;
  std::vector<std::string> problems_;
  int odometry_ = 0;
};

TEST_F(BagReplayTest, HandsOverKeyframesInOrder) {
  const ReplayReport report = Run(WriteFlight("a.bag", 20));
  EXPECT_EQ(report.messages, 100);
  EXPECT_EQ(report.bad_messages, 0);
  EXPECT_EQ(odometry_, 20);
  EXPECT_THAT(problems_, IsEmpty());
  ASSERT_EQ(keyframes_.size(), 20U);
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    EXPECT_EQ(keyframes_[i].stamp_ns, kStart + static_cast<std::int64_t>(i) * 100 * kMillisecond);
    EXPECT_EQ(keyframes_[i].T_W_B.t.x(), static_cast<double>(i));
    EXPECT_EQ(keyframes_[i].image.at<std::uint8_t>(47, 63), i);
    EXPECT_EQ(keyframes_[i].points.size(), i);
  }
  // A keyframe has the newest one before it: one of its own stamp may come too late.
  EXPECT_THAT(calibrations_, ElementsAre(::testing::Pair(1U, 0.25), ::testing::Pair(11U, 0.28125)));
}

TEST_F(BagReplayTest, ReadsAnotherBagsViewsOnlyWhereTheyAreWanted) {
  BagWriter views(Path("views.bag"));
  views.Write(topics_.virtual_frame, kStart, VirtualFrame());
  views.Close();
  const fs::path flight = WriteFlight("a.bag", 3);
  ReplayCallbacks callbacks = Callbacks();
  EXPECT_EQ(ReplayBag(flight, Path("views.bag"), topics_, {}, callbacks).messages, 15);
  EXPECT_THAT(problems_, IsEmpty());
  callbacks.on_virtual_view = [](const VirtualView&) {};
  EXPECT_EQ(ReplayBag(flight, Path("views.bag"), topics_, {}, callbacks).bad_messages, 1);
  EXPECT_THAT(problems_, ElementsAre(HasSubstr(topics_.virtual_frame)));
}

TEST_F(BagReplayTest, AnotherBagMayTellThatThereAreNoViews) {
  const fs::path flight = WriteFlight("a.bag", 3);
  ReplayCallbacks callbacks = Callbacks();
  callbacks.on_virtual_view = [](const VirtualView&) { FAIL(); };
  EXPECT_THROW(ReplayBag(flight, flight, topics_, {}, callbacks), InputError);
  BagWriter views(Path("none.bag"));
  views.Write(ViewTopics().settings, kStart, std_msgs::String());
  views.Close();
  EXPECT_EQ(ReplayBag(flight, Path("none.bag"), topics_, {}, callbacks).messages, 15);
}

TEST_F(BagReplayTest, GoesOnAfterMessagesThatCannotBeUsed) {
  BagWriter bag(Path("bad.bag"));
  for (int i = 0; i < 10; ++i) {
    const std::int64_t stamp = kStart + i * 100 * kMillisecond;
    sensor_msgs::Image image = MakeImage(stamp, 1);
    image.encoding = i == 2 ? "yuv422" : image.encoding;
    bag.Write(topics_.image, stamp, image);
    bag.Write(topics_.keyframe_pose, stamp, MakeOdometry(stamp, i == 4 ? std::nan("") : 1.0));
    sensor_msgs::PointCloud points = MakePoints(stamp, 5);
    points.channels.resize(i == 6 ? 1 : 5);
    bag.Write(topics_.keyframe_point, stamp, points);
  }
  bag.Close();
  const ReplayReport report = Run(Path("bad.bag"));
  EXPECT_EQ(report.bad_messages, 3);
  ASSERT_THAT(keyframes_, SizeIs(8));
  EXPECT_THAT(keyframes_[4].points, IsEmpty());
  EXPECT_EQ(report.assembler.missing_image, 1);
  EXPECT_EQ(report.assembler.missing_points, 1);
  EXPECT_THAT(problems_, ::testing::Contains(HasSubstr("yuv422")));
  EXPECT_THAT(problems_, ::testing::Contains(HasSubstr("missing_points")));
}

TEST_F(BagReplayTest, KeyframesThatAreRefusedAreReported) {
  ReplayCallbacks callbacks = Callbacks();
  callbacks.on_keyframe = [](const KeyframeInput&) { ThrowInputError("too small"); };
  const ReplayReport report = ReplayBag(WriteFlight("a.bag", 3), topics_, {}, callbacks);
  EXPECT_EQ(report.bad_messages, 3);
  EXPECT_THAT(problems_, ::testing::Each(HasSubstr("too small")));
}

TEST_F(BagReplayTest, ReadsCompressedImages) {
  BagWriter bag(Path("jpeg.bag"));
  sensor_msgs::CompressedImage image;
  image.header.stamp = ToRosTime(kStart);
  image.format = "png";
  cv::imencode(".png", cv::Mat(4, 5, CV_8UC1, cv::Scalar(9)), image.data);
  bag.Write(topics_.image, kStart, image);
  bag.Write(topics_.keyframe_pose, kStart, MakeOdometry(kStart, 0));
  bag.Write(topics_.keyframe_point, kStart, MakePoints(kStart, 1));
  bag.Close();
  Run(Path("jpeg.bag"));
  ASSERT_THAT(keyframes_, SizeIs(1));
  EXPECT_EQ(keyframes_[0].image.at<std::uint8_t>(0, 0), 9);
}

TEST_F(BagReplayTest, NeedsItsTopics) {
  topics_.keyframe_point = "/points";
  EXPECT_THAT(ErrorOf([&] { Run(WriteFlight("a.bag", 1)); }), HasSubstr("'/points'"));
  topics_ = {};
  topics_.image = topics_.odometry;
  EXPECT_THAT(ErrorOf([&] { Run(WriteFlight("a.bag", 1)); }),
              HasSubstr("sensor_msgs/Image or sensor_msgs/CompressedImage"));
}

TEST_F(BagReplayTest, DamagedBagsAreErrorsOrShorterFlights) {
  const fs::path path = WriteFlight("a.bag", 4);
  std::ifstream stream(path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  std::mt19937 random(3);
  for (int trial = 0; trial < 300; ++trial) {
    std::string damaged = content;
    for (int i = 0; i < 3; ++i) {
      damaged[random() % damaged.size()] = static_cast<char>(random());
    }
    std::ofstream(Path("damaged.bag"), std::ios::binary) << damaged;
    try {
      EXPECT_LE(Run(Path("damaged.bag")).assembler.keyframes, 4);
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr("damaged.bag"));
    }
  }
}

TEST_F(BagReplayTest, RealFlight) {
  const char* data = std::getenv("DEJA_VIEW_DATA");
  if (data == nullptr || !fs::exists(fs::path(data) / "hall_a" / "vins.bag")) {
    GTEST_SKIP() << "DEJA_VIEW_DATA does not name a directory with hall_a/vins.bag";
  }
  const BagReader bag(fs::path(data) / "hall_a" / "vins.bag");
  std::size_t points = 0;
  bag.Read({topics_.keyframe_point}, [&points](const rosbag::MessageInstance& instance) {
    points += FromKeyframePoints(*Instantiate<sensor_msgs::PointCloud>(instance), "points").size();
  });
  EXPECT_GT(points, 50000U);
}

TEST_F(BagReplayTest, MakesKeyframesOfImagesAndPosesAlone) {
  FrontEndSetup setup;
  setup.camera = SharedPinholeOf(64, 48, 40, 31.5, 23.5);
  VioTopics topics;
  topics.keyframe_pose.clear();
  const ReplayReport report =
      ReplayBag(WriteFlight("a.bag", 20), {}, topics, {}, Callbacks(), setup);
  EXPECT_EQ(report.messages, 40);  // no others are read
  EXPECT_EQ(report.front_end.images, 20);
  EXPECT_EQ(report.front_end.poses, 20);
  EXPECT_EQ(odometry_, 20);
  // Of grey walls nothing is known but that they were seen.
  ASSERT_EQ(keyframes_.size(), 20U);
  EXPECT_EQ(keyframes_[7].T_W_B.t.x(), 7.0);
  EXPECT_THAT(keyframes_[7].points, IsEmpty());
  topics.odometry = topics.keyframe_point;
  try {
    ReplayBag(Path("a.bag"), {}, topics, {}, Callbacks(), setup);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("geometry_msgs/PoseStamped"));
  }
}

TEST_F(BagReplayTest, MakesKeyframesOfImagesAndGivenPoses) {
  FrontEndSetup setup;
  setup.camera = SharedPinholeOf(64, 48, 40, 31.5, 23.5);
  VioTopics topics;
  topics.keyframe_pose.clear();
  const std::filesystem::path bag = WriteFlight("a.bag", 20);
  ReplayBag(bag, {}, topics, {}, Callbacks(), setup);
  const std::vector<KeyframeInput> of_topic = std::move(keyframes_);
  keyframes_.clear();
  topics.odometry = "/none";
  Trajectory T_W_B;
  for (const KeyframeInput& keyframe : of_topic) {
    T_W_B.stamps_ns.push_back(keyframe.stamp_ns);
    T_W_B.poses.push_back({keyframe.T_W_B.q, keyframe.T_W_B.t + Eigen::Vector3d(0, 5, 0)});
  }
  T_W_B.stamps_ns.push_back(T_W_B.stamps_ns.back() + 1'000'000'000);  // no image is so late
  T_W_B.poses.emplace_back();
  const ReplayReport report = ReplayBag(bag, {}, topics, {}, Callbacks(), setup, T_W_B);
  EXPECT_EQ(report.messages, 20);
  EXPECT_EQ(report.front_end.without_pose, 0);
  ASSERT_EQ(keyframes_.size(), of_topic.size());
  for (std::size_t i = 0; i < of_topic.size(); ++i) {
    EXPECT_EQ(keyframes_[i].stamp_ns, of_topic[i].stamp_ns);
    EXPECT_EQ(keyframes_[i].T_W_B.t, T_W_B.poses[i].t);
  }
}

}  // namespace
}  // namespace deja_view
