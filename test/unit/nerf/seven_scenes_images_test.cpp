#include "deja_view/base/check.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <cmath>

#include "image_files.hpp"
#include <gmock/gmock.h>

namespace deja_view::nerf {
namespace {

class SevenScenesTest : public ImageFilesTest {
 protected:
  SevenScenesTest() {
    Write("camera-intrinsics.txt", "5.85e+01 0 8\n0 5.85e+01 6\n0 0 1\n");
    for (const char* name : {"frame-000030", "frame-000000"}) {
      WriteImage(std::string(name) + ".color.png");
      Write(std::string(name) + ".pose.txt", "1 0 0 1\n0 0 -1 2\n0 1 0 3\n0 0 0 1\n");
    }
    WriteImage("frame-000030.depth.png", cv::Mat(12, 16, CV_16UC1, cv::Scalar(1500)));
  }
  std::string Error() const {
    return MessageOf<InputError>([&] { ReadSevenScenes(directory_); });
  }
};

TEST_F(SevenScenesTest, ReadsFrames) {
  const auto images = ReadSevenScenes(directory_);
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].name, "frame-000000");
  EXPECT_EQ(images[1].stamp_ns - images[0].stamp_ns, 1'000'000'000);
  EXPECT_TRUE(images[0].depth.path.empty());
  EXPECT_NEAR(ReadDepthMap(images[1]).at<float>(6, 8), 1.5, 1e-6);
  EXPECT_LT((images[1].T_N_C * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(1, 2, 4)).norm(), 1e-12);
  EXPECT_NEAR(images[0].camera->FocalLength(), 58.5, 1e-12);
  EXPECT_EQ(images[0].camera->height(), 12);
}

TEST_F(SevenScenesTest, TheColorCameraMayDifferFromTheDepthSensor) {
  const auto color_camera = SharedPinholeOf(16, 12, 50, 7, 5);
  const auto images = ReadSevenScenes(directory_, false, color_camera);
  EXPECT_EQ(images[1].camera, color_camera);
  EXPECT_NEAR(DepthCamera(images[1])->FocalLength(), 58.5, 1e-12);
  LoadOptions options;
  options.depth_step_px = 4;
  const TrainingView view = LoadViews({images[1]}, options).front();
  ASSERT_EQ(view.points.size(), 12U);  // of 4 x 3, all seen
  const DepthPoint& point = view.points.front();
  EXPECT_NEAR(point.u, 7 + 50 * (2 - 8) / 58.5, 1e-4);
  EXPECT_NEAR(point.v, 5 + 50 * (2 - 6) / 58.5, 1e-4);
  EXPECT_NEAR(point.range, 1.5 * std::hypot(1, 6 / 58.5, 4 / 58.5), 1e-4);
}

TEST_F(SevenScenesTest, MissingFilesAreErrors) {
  std::filesystem::remove(directory_ / "frame-000000.pose.txt");
  EXPECT_THAT(Error(), Says("1 of 2 frames have no pose", "frame-000000"));
  EXPECT_EQ(ReadSevenScenes(directory_, true).size(), 1U);
  std::filesystem::remove(directory_ / "frame-000030.color.png");
  EXPECT_THAT(Error(), Says("1 of 2 frames have no color image"));
  EXPECT_THAT(MessageOf<InputError>([&] { ReadSevenScenes(directory_, true); }),
              Says("expected frame-XXXXXX.color"));
  EXPECT_THAT(MessageOf<InputError>([&] { ReadSevenScenes(directory_ / "none"); }),
              Says("can't be listed"));
}

TEST_F(SevenScenesTest, MalformedFilesAreNamed) {
  for (const char* pose : {"1 0 0 1\n0 0 -1 2\n0 1 0 3\n0 0 0\n",
                           "1 0 0 nan\n0 0 -1 2\n0 1 0 3\n0 0 0 1\n",
                           "2 0 0 1\n0 0 -1 2\n0 1 0 3\n0 0 0 1\n",
                           "1 0 0 1\n0 0 1 2\n0 1 0 3\n0 0 0 1\n",
                           "-1.#IND 0 0 1\n"}) {
    Write("frame-000000.pose.txt", pose);
    EXPECT_THAT(Error(), Says("frame-000000.pose.txt")) << pose;
  }
  Write("frame-000000.pose.txt", "1 0 0 1\n0 0 -1 2\n0 1 0 3\n0 0 0 1\n");
  Write("camera-intrinsics.txt", "0 0 8\n0 58 6\n0 0 1\n");
  EXPECT_THAT(Error(), Says("camera-intrinsics.txt"));
  std::filesystem::remove(directory_ / "camera-intrinsics.txt");
  EXPECT_THAT(Error(), Says("camera-intrinsics.txt"));
}

}  // namespace
}  // namespace deja_view::nerf
