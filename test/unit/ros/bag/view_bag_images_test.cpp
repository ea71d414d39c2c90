#include "deja_view/ros/bag/view_bag.hpp"

#include "view_bag_fixture.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST_F(ViewBagTest, AFolderOfImagesGivesTheViewsOfABag) {
  job_.sources = SourceKind::kImages;
  Run(job_);
  WriteRoomImages("images/mav0/cam0/data");
  ViewJob folder = job_;
  folder.flight = OpenImageFlight(Path("images"), job_.topics.image, camera_);
  folder.sources = SourceKind::kAuto;
  folder.pose_topic = "/odometry";
  folder.T_B_C.t.x() = 0.1;
  folder.out = Path("folder.bag");
  const ViewReport report = Run(folder);
  EXPECT_EQ(report.sources, kImages);
  EXPECT_EQ(report.views, 2 * kImages);

  const auto without_times = [](std::vector<RawMessage> messages) {
    for (RawMessage& message : messages) {
      message.time_ns = 0;  // the bag's images come 3 ms late
    }
    return messages;
  };
  EXPECT_TRUE(without_times(ReadMessages(folder.out, true)) ==
              without_times(ReadMessages(job_.out, true)));
  int images = 0;
  int poses = 0;
  BagReader(folder.out).ReadAll([&](const rosbag::MessageInstance& m) {
    if (m.getTopic() == job_.topics.image) {
      const auto image = Instantiate<sensor_msgs::Image>(m);
      EXPECT_EQ(ToNanoseconds(m.getTime()), Stamp(images));
      EXPECT_EQ(ToNanoseconds(image->header.stamp), Stamp(images));
      const cv::Mat truth = RoomRenderer().Render(*camera_, Pose(images), {0.9F, 0.05F, 1}).image;
      EXPECT_EQ(cv::norm(FromImage(image, "")(), truth, cv::NORM_INF), 0);
      ++images;
    }
    if (m.getTopic() == folder.pose_topic) {
      const StampedPose pose = FromOdometry(*Instantiate<nav_msgs::Odometry>(m), m.getTopic());
      EXPECT_EQ(pose.stamp_ns, Stamp(poses));
      EXPECT_LT(((pose.pose * folder.T_B_C).t - Pose(poses).t).norm(), 1e-12);
      ++poses;
    }
  });
  EXPECT_EQ(images, kImages);
  EXPECT_EQ(poses, kImages);
}

TEST_F(ViewBagTest, AFolderOfImagesInSharesAndInterrupted) {
  WriteRoomImages("images");
  job_.flight = OpenImageFlight(Path("images"), job_.topics.image, camera_);
  job_.pose_topic = "/odometry";
  job_.threads = 1;
  job_.plain_topics = true;
  Run(job_);
  const std::string whole = Bytes(job_.out);
  std::vector<fs::path> parts;
  for (int i = 0; i < 2; ++i) {
    job_.shard = {i, 2};
    job_.out = Path("part" + std::to_string(i) + ".bag");
    interrupt_at_ = 2;
    EXPECT_THROW(Run(job_), std::runtime_error);
    interrupt_at_ = 1000;
    EXPECT_EQ(Run(job_).resumed, 2);
    parts.push_back(job_.out);
  }
  MergeViews(*job_.flight, {parts[1], parts[0]}, Path("merged.bag"));
  EXPECT_EQ(Bytes(Path("merged.bag")), whole);
}

TEST_F(ViewBagTest, FindsAnUnusableImageBeforeItRenders) {
  WriteRoomImages("images");
  const fs::path last = Path("images") / (std::to_string(Stamp(kImages - 1)) + ".png");
  std::ofstream(last) << "no picture";
  job_.flight = OpenImageFlight(Path("images"), job_.topics.image, camera_);
  EXPECT_THAT(ErrorOf([&] { Run(job_); }), HasSubstr(last.string()));
  EXPECT_EQ(rendered_, 0);
  EXPECT_FALSE(fs::exists(job_.out));
}

}  // namespace
}  // namespace deja_view
