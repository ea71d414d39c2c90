#include "deja_view/camera/kannala_brandt_camera.hpp"

#include "deja_view/base/check.hpp"

#include <limits>

#include "camera_checks.hpp"
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

namespace deja_view {
namespace {

// A lens of about 180 degrees, as of the TUM-VI cameras.
KannalaBrandtParameters Fisheye() {
  return {752, 480, 0.0034, 0.0007, -0.0020, 0.0002, 260.0, 259.0, 371.0, 243.0};
}

TEST(KannalaBrandtCamera, ProjectsAsOpenCv) {
  const KannalaBrandtParameters p = Fisheye();
  const KannalaBrandtCamera camera(p);
  const cv::Matx33d K(p.mu, 0, p.u0, 0, p.mv, p.v0, 0, 0, 1);
  const cv::Vec4d distortion(p.k2, p.k3, p.k4, p.k5);
  test::ExpectProjectsAs(camera, [&](const auto& points, auto* pixels) {
    cv::fisheye::projectPoints(points, *pixels, cv::Vec3d(), cv::Vec3d(), K, distortion);
  });
}

TEST(KannalaBrandtCamera, UnprojectIsTheInverse) {
  test::ExpectRoundTrip(KannalaBrandtCamera(Fisheye()));
  KannalaBrandtParameters strong = Fisheye();
  strong.k2 = -0.03;
  strong.k3 = -0.001;
  strong.k4 = strong.k5 = 0;
  test::ExpectRoundTrip(KannalaBrandtCamera(strong));
}

TEST(KannalaBrandtCamera, JacobianIsTheDerivative) {
  test::ExpectJacobian(KannalaBrandtCamera(Fisheye()));
}

TEST(KannalaBrandtCamera, SeesBehindTheImagePlaneButNotBeyondItsLargestAngle) {
  const KannalaBrandtCamera camera(Fisheye());
  EXPECT_TRUE(camera.Project({1.0, 0.0, -0.1}).has_value());
  EXPECT_FALSE(camera.Project({0.0, 0.0, 0.0}).has_value());
  EXPECT_FALSE(camera.Project({0.0, 0.0, -1.0}).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.Project({nan, 0.0, 1.0}).has_value());

  KannalaBrandtParameters folding = Fisheye();
  folding.k2 = -0.2;  // theta - 0.2 theta^3 turns back at sqrt(1 / 0.6) = 1.291
  folding.k3 = folding.k4 = folding.k5 = 0;
  const KannalaBrandtCamera lens(folding);
  EXPECT_TRUE(lens.Project({std::sin(1.290), 0.0, std::cos(1.290)}).has_value());
  EXPECT_FALSE(lens.Project({std::sin(1.292), 0.0, std::cos(1.292)}).has_value());
  test::ExpectFiniteRaysFarOutside(lens);
}

TEST(KannalaBrandtCamera, ScalingKeepsPixelCentres) {
  test::ExpectScaledKeepsRays(KannalaBrandtCamera(Fisheye()));
}

TEST(KannalaBrandtCamera, RefusesImpossibleParameters) {
  KannalaBrandtParameters p = Fisheye();
  p.mu = -1;
  EXPECT_THROW(KannalaBrandtCamera{p}, CheckError);
  p = Fisheye();
  p.k5 = std::numeric_limits<double>::infinity();
  EXPECT_THROW(KannalaBrandtCamera{p}, CheckError);
}

}  // namespace
}  // namespace deja_view
