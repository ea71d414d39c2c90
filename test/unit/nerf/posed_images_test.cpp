#include "deja_view/nerf/posed_images.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

namespace deja_view::nerf {
namespace {

namespace fs = std::filesystem;

class PosedImagesTest : public testing::Test {
 protected:
  PosedImagesTest()
      : directory_(fs::temp_directory_path() / ("deja_view_images_" + std::to_string(::getpid()))) {
    fs::create_directories(directory_);
    PinholeParameters parameters;
    parameters.width = 16;
    parameters.height = 12;
    parameters.fx = parameters.fy = 10;
    parameters.cx = 7.5;
    parameters.cy = 5.5;
    camera_ = std::make_shared<PinholeCamera>(parameters);
    trajectory_.stamps_ns = {1'000'000'000, 1'050'000'000, 1'100'000'000};
    for (int i = 0; i < 3; ++i) {
      trajectory_.poses.push_back({Eigen::Quaterniond::Identity(), Eigen::Vector3d(i, 0, 0)});
    }
  }
  ~PosedImagesTest() override { fs::remove_all(directory_); }

  void WriteImage(const std::string& name, cv::Size size = {16, 12}) const {
    cv::imwrite((directory_ / name).string(), cv::Mat(size, CV_8UC1, cv::Scalar(77)));
  }

  fs::path directory_;
  std::shared_ptr<const Camera> camera_;
  Trajectory trajectory_;
};

TEST_F(PosedImagesTest, FollowTheTrajectory) {
  WriteImage("1025000000.png");
  WriteImage("1000000000.png");
  std::ofstream(directory_ / "notes.txt") << "no image";
  const Rigid3 T_B_C{Eigen::Quaterniond::Identity(), {0, 0, 3}};
  const std::vector<PosedImage> images =
      ReadTrajectoryImages(directory_, camera_, T_B_C, trajectory_);
  ASSERT_EQ(images.size(), std::size_t{2});
  EXPECT_EQ(images[0].stamp_ns, 1'000'000'000);
  EXPECT_LT((images[1].T_N_C.t - Eigen::Vector3d(0.5, 0, 3)).norm(), 1e-12);
}

TEST_F(PosedImagesTest, ErrorsNameTheFile) {
  const auto message = [&] {
    try {
      ReadTrajectoryImages(directory_, camera_, {}, trajectory_);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(message().find("holds no image"), std::string::npos);
  WriteImage("1000000000.png");
  WriteImage("2000000000.png");
  EXPECT_NE(message().find("1 of 2 images"), std::string::npos);
  WriteImage("frame7.png");
  EXPECT_NE(message().find("frame7.png"), std::string::npos);
}

TEST_F(PosedImagesTest, LoadShrinksImageAndCamera) {
  WriteImage("1000000000.png");
  const auto images = ReadTrajectoryImages(directory_, camera_, {}, trajectory_);
  const std::vector<TrainingView> views = LoadViews(images, 3, 0.5, 1);
  ASSERT_EQ(views.size(), std::size_t{1});
  EXPECT_EQ(views[0].image.type(), CV_8UC3);
  EXPECT_EQ(views[0].image.size(), cv::Size(8, 6));
  EXPECT_EQ(views[0].camera->width(), 8);
  EXPECT_EQ(views[0].image.at<cv::Vec3b>(2, 2)[1], 77);
}

TEST_F(PosedImagesTest, LoadRefusesOtherSizesAndBrokenFiles) {
  WriteImage("1000000000.png", {10, 10});
  auto images = ReadTrajectoryImages(directory_, camera_, {}, trajectory_);
  EXPECT_THROW(LoadViews(images, 1, 1, 1), InputError);
  std::ofstream(directory_ / "1000000000.png") << "not a picture";
  EXPECT_THROW(LoadViews(images, 1, 1, 1), InputError);
}

TEST_F(PosedImagesTest, HoldOutTakesEveryNth) {
  const std::vector<PosedImage> images(7);
  const Split split = HoldOut(images, 3);
  EXPECT_EQ(split.held_out.size(), std::size_t{3});
  EXPECT_EQ(split.training.size(), std::size_t{4});
  EXPECT_TRUE(HoldOut(images, 0).held_out.empty());
}

}  // namespace
}  // namespace deja_view::nerf
