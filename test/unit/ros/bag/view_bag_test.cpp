#include "deja_view/ros/bag/view_bag.hpp"

#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <set>

#include "view_bag_fixture.hpp"
#include <gmock/gmock.h>

#include <sensor_msgs/CameraInfo.h>
#include <std_msgs/String.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST_F(ViewBagTest, KeepsAllMessagesAndPutsViewsBehindTheirImages) {
  const ViewReport report = Run(job_);
  EXPECT_EQ(report.images, 3);  // keyframes
  EXPECT_EQ(report.sources, 3);
  EXPECT_EQ(report.views, 6);
  EXPECT_GT(report.bytes, 6000);
  EXPECT_TRUE(ReadMessages(job_.out, false) == ReadMessages(job_.flight->path(), false));
  EXPECT_FALSE(fs::exists(job_.out.string() + ".work"));

  std::int64_t image_time = 0;
  int frames = 0;
  BagReader(job_.out).ReadAll([&](const rosbag::MessageInstance& m) {
    if (m.getTopic() == VioTopics().image) {
      image_time = ToNanoseconds(m.getTime());
    }
    if (m.getTopic() == ViewTopics().frame) {
      const auto message = Instantiate<VirtualFrame>(m);
      const VirtualView view = FromVirtualFrame(*message, m.getTopic());
      EXPECT_EQ(view.stamp_ns, Stamp(frames / 2 * 2));
      EXPECT_EQ(view.index, frames % 2);
      EXPECT_EQ(view.count, 2);
      EXPECT_EQ(message->header.frame_id, "cam0");
      EXPECT_EQ(ToNanoseconds(m.getTime()), image_time + 1 + view.index);
      const cv::Mat truth =
          RoomRenderer()
              .Render(*camera_, Pose(frames / 2 * 2) * view.T_C_V, {0.9F, 0.05F, 1})
              .image;
      EXPECT_LT(cv::norm(view.image, truth, cv::NORM_L1) / 19200, 3);
      ++frames;
    }
    if (m.getTopic() == ViewTopics().settings) {
      EXPECT_EQ(Instantiate<std_msgs::String>(m)->data, "room\n");
    }
  });
  EXPECT_EQ(frames, 6);
}

TEST_F(ViewBagTest, AllImagesOrAFewOfThem) {
  job_.sources = SourceKind::kImages;
  job_.options.sources.every_m = 0.8;
  const ViewReport report = Run(job_);
  EXPECT_EQ(report.images, kImages);
  EXPECT_EQ(report.sources, 3);  // 0.41 m apart
  job_.T_N_C.stamps_ns.resize(2);
  job_.T_N_C.poses.resize(2);
  const ViewReport few = Run(job_);
  EXPECT_EQ(few.images, 2);
  EXPECT_EQ(few.without_pose, kImages - 2);
  job_.T_N_C.stamps_ns = {1, 2};
  EXPECT_THAT(ErrorOf([&] { Run(job_); }), HasSubstr("none of the 6 images"));
}

TEST_F(ViewBagTest, ImagesAtGivenStampsWhateverTheSpacing) {
  job_.sources = SourceKind::kImages;
  job_.options.sources.every_m = 100;
  job_.source_stamps_ns = {Stamp(4), KeyframeAssembler::Key(Stamp(1))};  // as VIOs round it
  EXPECT_EQ(Run(job_).sources, 2);
  std::set<std::int64_t> stamps;
  BagReader(job_.out).Read({ViewTopics().frame}, [&](const rosbag::MessageInstance& m) {
    stamps.insert(ToNanoseconds(Instantiate<VirtualFrame>(m)->header.stamp));
  });
  EXPECT_EQ(stamps, (std::set<std::int64_t>{Stamp(1), Stamp(4)}));
  job_.source_stamps_ns = {Stamp(0) - 50 * kMillisecond};
  EXPECT_THAT(ErrorOf([&] { Run(job_); }), HasSubstr("none of the 6 images"));
}

TEST_F(ViewBagTest, GoesOnWhereItWasKilled) {
  job_.threads = 1;  // more may have finished further images by then
  Run(job_);
  const std::string whole = Bytes(job_.out);
  job_.out = Path("again.bag");
  interrupt_at_ = 2;
  rendered_ = 0;
  EXPECT_THROW(Run(job_), std::runtime_error);
  EXPECT_EQ(rendered_, 2);
  EXPECT_FALSE(fs::exists(job_.out));
  interrupt_at_ = 1000;
  const ViewReport report = Run(job_);
  EXPECT_EQ(report.resumed, 2);
  EXPECT_EQ(report.views, 6);
  EXPECT_EQ(rendered_, 3);
  EXPECT_EQ(Bytes(job_.out), whole);
  EXPECT_FALSE(fs::exists(job_.out.string() + ".work"));
}

TEST_F(ViewBagTest, StartsAnewWithOtherSettingsOrOnRequest) {
  job_.threads = 1;
  const auto resumed_after = [this](const std::function<void()>& change) {
    interrupt_at_ = 2;
    EXPECT_THROW(Run(job_), std::runtime_error);
    interrupt_at_ = 1000;
    change();
    return Run(job_).resumed;
  };
  EXPECT_EQ(resumed_after([this] { job_.settings = "other\n"; }), 0);
  EXPECT_EQ(resumed_after([this] { job_.T_N_C.poses[0].t.x() += 1e-9; }), 0);
  EXPECT_EQ(resumed_after([this] { job_.content.depth = true; }), 0);
  EXPECT_EQ(resumed_after([this] { job_.resume = false; }), 0);
  job_.resume = true;
  EXPECT_EQ(resumed_after([] {}), 2);
}

TEST_F(ViewBagTest, SharesMergeToTheSameFile) {
  job_.sources = SourceKind::kImages;
  Run(job_);
  std::vector<fs::path> parts;
  for (int i = 0; i < 3; ++i) {
    ViewJob part = job_;
    part.shard = {i, 3};
    part.out = Path("part" + std::to_string(i) + ".bag");
    EXPECT_EQ(Run(part).sources, 2);
    parts.push_back(part.out);
  }
  const fs::path merged = Path("merged.bag");
  const ViewReport report = MergeViews(*job_.flight, {parts[2], parts[0], parts[1]}, merged);
  EXPECT_EQ(report.views, 12);
  EXPECT_EQ(Bytes(merged), Bytes(job_.out));

  const fs::path views_only = Path("views_only.bag");
  MergeViews(*job_.flight, parts, views_only, true);
  const BagReader reader(views_only);
  for (const BagReader::Topic& topic : reader.topics()) {
    EXPECT_THAT(topic.name, HasSubstr("/virtual_cam0/"));
    EXPECT_EQ(topic.messages, topic.name == "/virtual_cam0/frame" ? 12 : 1);
  }

  EXPECT_THAT(ErrorOf([&] {
                MergeViews(*job_.flight, {parts[0], parts[2]}, merged);
              }),
              HasSubstr("part 1 of 3 is missing"));
  EXPECT_THAT(ErrorOf([&] {
                MergeViews(*job_.flight, {parts[0], parts[1], parts[0]}, merged);
              }),
              HasSubstr("part 0 of 3 is given twice"));
  EXPECT_THAT(ErrorOf([&] { MergeViews(*OpenBagFlight(merged), parts, Path("x.bag")); }),
              HasSubstr("has virtual views"));
  EXPECT_THAT(ErrorOf([&] { MergeViews(*job_.flight, {job_.flight->path()}, Path("x.bag")); }),
              HasSubstr("/virtual_cam0/settings"));
  ViewJob other = job_;
  other.settings = "other\n";
  other.shard = {1, 3};
  other.out = parts[1];
  Run(other);
  EXPECT_THAT(ErrorOf([&] { MergeViews(*job_.flight, parts, Path("x.bag")); }),
              HasSubstr("other settings"));
  EXPECT_FALSE(fs::exists(Path("x.bag")));
}

TEST_F(ViewBagTest, RefusesPosesOfAnotherFrame) {
  for (Rigid3& pose : job_.T_N_C.poses) {
    pose.t.y() += 1.5;
  }
  EXPECT_THAT(ErrorOf([&] { Run(job_); }),
              ::testing::AllOf(HasSubstr("all 3 images"), HasSubstr("frame")));
  EXPECT_FALSE(fs::exists(job_.out));
}

TEST_F(ViewBagTest, HandsOverTheVioPoints) {
  Run(job_);
  ASSERT_EQ(points_.size(), 3U);
  for (const RangeSample& point : points_) {
    EXPECT_NEAR(point.range_m, 1.5, 1e-5);
    EXPECT_EQ(point.pixel, Eigen::Vector2d(10, 20));
  }
}

TEST_F(ViewBagTest, WritesPlainTopicsOnRequest) {
  job_.plain_topics = true;
  Run(job_);
  const ViewTopics topics;
  std::set<std::int64_t> times;
  int images = 0;
  BagReader(job_.out).ReadAll([&](const rosbag::MessageInstance& m) {
    if (m.getTopic().find("/virtual") == 0) {
      EXPECT_TRUE(times.insert(ToNanoseconds(m.getTime())).second ||
                  m.getTopic() == topics.settings);
    }
    if (m.getTopic() == topics.image) {
      const auto image = Instantiate<sensor_msgs::Image>(m);
      EXPECT_EQ(image->width, 160U);
      EXPECT_EQ(image->header.frame_id, "cam0");
      ++images;
    }
    if (m.getTopic() == topics.camera_info) {
      const auto info = Instantiate<sensor_msgs::CameraInfo>(m);
      EXPECT_EQ(info->distortion_model, "plumb_bob");
      EXPECT_EQ(info->K[4], 100);
    }
  });
  EXPECT_EQ(images, 6);
  EXPECT_EQ(BagReader(job_.out).TypeOf(topics.pose), "geometry_msgs/PoseStamped");
}

TEST_F(ViewBagTest, CompressesImagesAsAsked) {
  job_.options.image_format = ImageFormat::kPng;
  Run(job_);
  int views = 0;
  BagReader(job_.out).ReadAll([&](const rosbag::MessageInstance& m) {
    if (m.getTopic() == ViewTopics().frame) {
      const auto frame = Instantiate<VirtualFrame>(m);
      EXPECT_EQ(frame->image_format, "png");
      EXPECT_EQ(FromVirtualFrame(*frame, m.getTopic()).image.rows, 120);
      ++views;
    }
  });
  EXPECT_EQ(views, 6);
}

TEST_F(ViewBagTest, NamesAnImageOfAnotherSize) {
  job_.camera = camera_->Scaled(0.5);
  EXPECT_THAT(ErrorOf([&] { Run(job_); }),
              ::testing::AllOf(HasSubstr("160 x 120"), HasSubstr("80 x 60")));
}

}  // namespace
}  // namespace deja_view
