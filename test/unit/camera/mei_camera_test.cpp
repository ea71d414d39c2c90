#include "deja_view/camera/mei_camera.hpp"

#include <limits>
#include <random>

#include <gtest/gtest.h>
#ifdef DEJA_VIEW_HAVE_OMNIDIR
#include <opencv2/ccalib/omnidir.hpp>
#endif

#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include "camera_checks.hpp"

namespace deja_view {
namespace {

MeiParameters Omnidirectional() {
  return {752, 480, 0.9, -0.1, 0.05, 1e-3, -5e-4, 470.0, 468.0, 371.0, 243.0};
}

MeiParameters WithMirrorBeyondOne() {
  MeiParameters p = Omnidirectional();
  p.xi = 1.9;
  p.gamma1 = 900;
  p.gamma2 = 903;
  return p;
}

#ifdef DEJA_VIEW_HAVE_OMNIDIR
TEST(MeiCamera, ProjectsAsOpenCv) {
  for (const MeiParameters& p : {Omnidirectional(), WithMirrorBeyondOne()}) {
    const MeiCamera camera(p);
    const cv::Matx33d K(p.gamma1, 0, p.u0, 0, p.gamma2, p.v0, 0, 0, 1);
    const cv::Vec4d distortion(p.k1, p.k2, p.p1, p.p2);
    test::ExpectProjectsAs(camera, [&](const auto& points, auto* pixels) {
      cv::omnidir::projectPoints(points, *pixels, cv::Vec3d(), cv::Vec3d(), K, p.xi, distortion);
    });
  }
}
#else
TEST(MeiCamera, ProjectsAsOpenCv) {
  GTEST_SKIP() << "built without OpenCV's ccalib module";
}
#endif

TEST(MeiCamera, WithoutMirrorIsAPinhole) {
  MeiParameters p = Omnidirectional();
  p.xi = 0;
  const MeiCamera camera(p);
  const PinholeCamera pinhole(
      PinholeParameters{p.width, p.height, p.gamma1, p.gamma2, p.u0, p.v0, p.k1, p.k2, p.p1, p.p2});
  std::mt19937 rng(2);
  for (int i = 0; i < 50; ++i) {
    Eigen::Vector3d p_C = test::RandomPointInFront(rng);
    EXPECT_LT((*camera.Project(p_C) - *pinhole.Project(p_C)).norm(), 1e-10);
  }
  EXPECT_FALSE(camera.Project({0.1, 0.0, -0.1}).has_value());
}

TEST(MeiCamera, UnprojectIsTheInverse) {
  test::ExpectRoundTrip(MeiCamera(Omnidirectional()));
  test::ExpectRoundTrip(MeiCamera(WithMirrorBeyondOne()));
  MeiParameters parabolic = Omnidirectional();
  parabolic.xi = 1.0;
  test::ExpectRoundTrip(MeiCamera(parabolic));
}

TEST(MeiCamera, JacobianIsTheDerivative) {
  test::ExpectJacobian(MeiCamera(Omnidirectional()));
  test::ExpectJacobian(MeiCamera(WithMirrorBeyondOne()));
}

TEST(MeiCamera, SeesOnlyWhereItIsOneToOne) {
  const MeiCamera camera(Omnidirectional());
  EXPECT_FALSE(camera.Project({0.0, 0.0, 0.0}).has_value());
  EXPECT_FALSE(camera.Project({0.0, 0.0, -1.0}).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.Project({nan, 0.0, 1.0}).has_value());

  MeiParameters p = WithMirrorBeyondOne();
  p.k1 = p.k2 = p.p1 = p.p2 = 0;
  const MeiCamera mirror(p);
  const double limit = std::acos(-1.0 / p.xi);  // 121.8 degrees off the axis
  EXPECT_TRUE(mirror.Project({std::sin(limit - 1e-3), 0.0, std::cos(limit - 1e-3)}).has_value());
  EXPECT_FALSE(mirror.Project({std::sin(limit + 1e-3), 0.0, std::cos(limit + 1e-3)}).has_value());
  test::ExpectFiniteRaysFarOutside(mirror);
  test::ExpectFiniteRaysFarOutside(camera);
}

TEST(MeiCamera, ScalingKeepsPixelCentres) {
  test::ExpectScaledKeepsRays(MeiCamera(Omnidirectional()));
  EXPECT_NEAR(MeiCamera(Omnidirectional()).FocalLength(), 469.0 / 1.9, 1e-12);
}

TEST(MeiCamera, RefusesImpossibleParameters) {
  MeiParameters p = Omnidirectional();
  p.xi = -0.1;
  EXPECT_THROW(MeiCamera{p}, CheckError);
  p = Omnidirectional();
  p.gamma2 = 0;
  EXPECT_THROW(MeiCamera{p}, CheckError);
}

}  // namespace
}  // namespace deja_view
