#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <fstream>

#include "image_files.hpp"
#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

namespace deja_view::nerf {
namespace {

class DepthMapImagesTest : public ImageFilesTest {
 protected:
  // 1 m at the left, 2 m at the right of column 8.
  static cv::Mat Step() {
    cv::Mat depth(12, 16, CV_16UC1, cv::Scalar(1000));
    depth(cv::Rect(8, 0, 8, 12)).setTo(2000);
    depth.at<std::uint16_t>(0, 0) = 0;
    depth.at<std::uint16_t>(0, 1) = 65535;
    return depth;
  }
  template <typename Call>
  static std::string ErrorOf(const Call& call) {
    try {
      call();
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
};

TEST_F(DepthMapImagesTest, AreFoundByTheirStamps) {
  WriteImage("maps/1403636625.838560104.png", Step());
  WriteImage("maps/1403636625738560104.png", Step());
  const std::vector<PosedImage> maps =
      ListDepthMaps(directory_ / "maps", SmallCamera(), 1e-3, false);
  ASSERT_EQ(maps.size(), 2U);
  EXPECT_EQ(maps[0].stamp_ns, 1403636625738560104);
  EXPECT_EQ(maps[1].stamp_ns, 1403636625838560104);
  EXPECT_EQ(maps[1].depth.path.filename(), "1403636625.838560104.png");
  WriteImage("maps/first.png", Step());
  EXPECT_THAT(ErrorOf([&] { ListDepthMaps(directory_ / "maps", SmallCamera(), 1e-3, false); }),
              Says("first.png", "stamp"));
  EXPECT_THAT(ErrorOf([&] { ListDepthMaps(directory_ / "none", SmallCamera(), 1e-3, false); }),
              Says("none"));
}

TEST_F(DepthMapImagesTest, MeasureAlongTheAxisOrAlongTheRay) {
  const auto camera = SmallCamera();
  WriteImage("1403636625738560104.png", Step());
  const cv::Mat by_axis = ReadImageDepth(ListDepthMaps(directory_, camera, 1e-3, false).front());
  const cv::Mat by_ray = ReadImageDepth(ListDepthMaps(directory_, camera, 1e-3, true).front());
  const cv::Mat halves = ReadImageDepth(ListDepthMaps(directory_, camera, 5e-4, true).front());
  for (int y = 0; y < 12; ++y) {
    for (int x = y == 0 ? 2 : 0; x < 16; ++x) {
      const float z = x < 8 ? 1.0F : 2.0F;
      EXPECT_FLOAT_EQ(by_ray.at<float>(y, x), z);
      EXPECT_FLOAT_EQ(halves.at<float>(y, x), z / 2);
      const Eigen::Vector3d p =
          static_cast<double>(by_axis.at<float>(y, x)) * camera->Unproject({x, y});
      EXPECT_NEAR(p.z(), static_cast<double>(z), 1e-6);
    }
  }
  EXPECT_EQ(by_axis.at<float>(0, 0), 0.0F);
  EXPECT_EQ(by_ray.at<float>(0, 1), 0.0F);
}

// 7-Scenes' depth camera has a longer focal length than the one that took the colour images.
TEST_F(DepthMapImagesTest, OfAnotherCameraAreSeenByTheImages) {
  std::ofstream(directory_ / "camera-intrinsics.txt") << "20 0 7.5\n0 20 5.5\n0 0 1\n";
  const char* kPose = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  for (const char* frame : {"frame-000000", "frame-000030"}) {
    std::ofstream(directory_ / (std::string(frame) + ".pose.txt")) << kPose;
    WriteImage(std::string(frame) + ".color.png");
  }
  EXPECT_THAT(ErrorOf([&] { ListDepthMaps(directory_, SmallCamera(), 1e-3, false); }),
              Says("depth.png"));
  WriteImage("frame-000030.depth.png", Step());
  const std::vector<PosedImage> maps = ListDepthMaps(directory_, SmallCamera(), 1e-3, false);
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0].stamp_ns, 1'001'000'000'000);  // as scripts/images_to_bag has it
  const cv::Mat range = ReadImageDepth(maps[0]);
  // Half as many pixels: from column 3.75 on and up to 11.25.
  for (int x = 0; x < 16; ++x) {
    const double z = x < 4 || x > 11 ? 0.0 : (x < 8 ? 1.0 : 2.0);
    const Eigen::Vector3d p =
        static_cast<double>(range.at<float>(5, x)) * SmallCamera()->Unproject({x, 5});
    EXPECT_NEAR(p.z(), z, 1e-5) << x;
  }
}

}  // namespace
}  // namespace deja_view::nerf
