#include "camera_block.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include "bundle_scene.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

TEST(CameraBlock, ProjectsWithTheNumbersItIsGiven) {
  PinholeParameters lens = test::BundleLens();
  CameraBlock block{PinholeCamera(lens)};
  std::vector<double> projection = block.parameters().projection;
  std::vector<double> distortion = block.parameters().distortion;
  const Eigen::Vector3d p_C(0.4, 0.3, 1.5);
  const auto project = [&] {
    return block.Project(projection.data(), distortion.data(), p_C, nullptr, nullptr, nullptr)
        .value();
  };
  EXPECT_EQ(project(), PinholeCamera(lens).Project(p_C).value());
  projection[0] = lens.fx = 500;  // not the numbers seen last
  EXPECT_EQ(project(), PinholeCamera(lens).Project(p_C).value());
  distortion[1] = lens.k2 = 0.3;
  EXPECT_EQ(project(), PinholeCamera(lens).Project(p_C).value());
}

TEST(CameraBlock, DerivativesFollowTheNumbers) {
  PinholeParameters lens = test::BundleLens();
  CameraBlock block{PinholeCamera(lens)};
  std::vector<double> projection = block.parameters().projection;
  const std::vector<double> distortion = block.parameters().distortion;
  const Eigen::Vector3d p_C(0.4, 0.3, 1.5);
  for (const double cx : {322.0, 300.0}) {
    projection[2] = cx;
    Eigen::Matrix<double, 2, 4, Eigen::RowMajor> J;
    const auto pixel =
        block.Project(projection.data(), distortion.data(), p_C, nullptr, J.data(), nullptr);
    // u = fx x + cx
    EXPECT_NEAR(J(0, 0), (pixel->x() - cx) / projection[0], 1e-8);
    EXPECT_NEAR(J(0, 2), 1, 1e-8);
    EXPECT_NEAR(J(1, 3), 1, 1e-8);
    EXPECT_NEAR(J(0, 1), 0, 1e-8);
  }
}

TEST(CameraBlock, SeesNothingWithNumbersThatMakeNoCamera) {
  CameraBlock block{PinholeCamera(test::BundleLens())};
  std::vector<double> projection = block.parameters().projection;
  const std::vector<double> distortion = block.parameters().distortion;
  projection[1] = -1;
  EXPECT_FALSE(
      block.Project(projection.data(), distortion.data(), {0, 0, 1}, nullptr, nullptr, nullptr));
  EXPECT_EQ(block.Make(projection.data(), distortion.data()), nullptr);
}

}  // namespace
}  // namespace deja_view::internal
