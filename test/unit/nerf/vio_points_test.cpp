#include "deja_view/nerf/image_readers.hpp"

#include "image_files.hpp"

namespace deja_view::nerf {
namespace {

class VioPointsTest : public ImageFilesTest {};

TEST_F(VioPointsTest, GoToTheImagesOfTheirStamp) {
  std::vector<PosedImage> images(2);
  images[0].stamp_ns = 1'000'000'000;
  images[1].stamp_ns = 2'000'000'000;
  for (PosedImage& image : images) {
    image.camera = SmallCamera();
  }
  VioKeyframe keyframe;
  keyframe.stamp_ns = 2'000'000'120;
  // The VIO's world has nothing to do with that of the images: only the distance counts.
  keyframe.T_W_C = {ExpSo3({0.4, 0.5, 0.6}), {100, 200, 300}};
  for (const Eigen::Vector3d& p_C : {Eigen::Vector3d(0, 0, 2), Eigen::Vector3d(0.3, 0, 3)}) {
    keyframe.p_W.push_back(keyframe.T_W_C * p_C);
  }
  keyframe.pixels = {{7.5, 5.5}, {8.0, 5.0}};
  EXPECT_EQ(AddVioPoints({keyframe}, &images), 1U);
  EXPECT_TRUE(images[0].points.empty());
  ASSERT_EQ(images[1].points.size(), 2U);
  EXPECT_EQ(images[1].points[0].u, 7.5F);
  EXPECT_NEAR(images[1].points[0].range, 2, 1e-6);
  EXPECT_NEAR(images[1].points[1].range, std::sqrt(9.09), 1e-6);
}

TEST_F(VioPointsTest, WrongOnesAreLeftOut) {
  std::vector<PosedImage> images(1);
  images[0].stamp_ns = 5000;
  images[0].camera = SmallCamera();
  VioKeyframe keyframe;
  keyframe.stamp_ns = 5000;
  keyframe.p_W = {{0, 0, 2}, {0, 0, -2}, {3, 0, 2}};  // 4 px away; behind; outside
  keyframe.pixels = {{11.5, 5.5}, {7.5, 5.5}, {22.5, 5.5}};
  EXPECT_EQ(AddVioPoints({keyframe}, &images), 0U);
  EXPECT_TRUE(images[0].points.empty());
  keyframe.stamp_ns = 7000;
  keyframe.pixels[0] = {7.5, 5.5};
  EXPECT_EQ(AddVioPoints({keyframe}, &images), 0U);  // another stamp
  keyframe.stamp_ns = 5900;
  EXPECT_EQ(AddVioPoints({keyframe}, &images), 1U);
}

}  // namespace
}  // namespace deja_view::nerf
