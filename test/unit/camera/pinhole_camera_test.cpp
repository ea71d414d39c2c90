#include "deja_view/camera/pinhole_camera.hpp"

#include "deja_view/base/check.hpp"

#include <limits>

#include "camera_checks.hpp"
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

namespace deja_view {
namespace {

PinholeParameters EurocParameters() {
  return {752, 480, 461.6, 460.3, 363.0, 248.1, -0.2917, 0.08228, 5.333e-5, -1.578e-4};
}

TEST(PinholeCamera, ProjectsAsOpenCv) {
  const PinholeParameters p = EurocParameters();
  const PinholeCamera camera(p);
  const cv::Matx33d K(p.fx, 0, p.cx, 0, p.fy, p.cy, 0, 0, 1);
  const cv::Vec4d distortion(p.k1, p.k2, p.p1, p.p2);
  test::ExpectProjectsAs(camera, [&](const auto& points, auto* pixels) {
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), K, distortion, *pixels);
  });
}

TEST(PinholeCamera, UnprojectIsTheInverse) {
  test::ExpectRoundTrip(PinholeCamera(EurocParameters()));
  PinholeParameters strong = EurocParameters();
  strong.k1 = -0.35;
  strong.k2 = 0.15;
  strong.p1 = 1e-3;
  strong.p2 = -2e-3;
  test::ExpectRoundTrip(PinholeCamera(strong));
  PinholeParameters none = EurocParameters();
  none.k1 = none.k2 = none.p1 = none.p2 = 0;
  test::ExpectRoundTrip(PinholeCamera(none));
}

TEST(PinholeCamera, JacobianIsTheDerivative) {
  test::ExpectJacobian(PinholeCamera(EurocParameters()));
}

TEST(PinholeCamera, SeesNothingBehindItOrWhereTheLensFoldsBack) {
  const PinholeCamera camera(EurocParameters());
  EXPECT_FALSE(camera.Project({0.1, 0.1, 0.0}).has_value());
  EXPECT_FALSE(camera.Project({0.1, 0.1, -1.0}).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.Project({nan, 0.0, 1.0}).has_value());

  PinholeParameters folding = EurocParameters();
  folding.k2 = 0;  // r (1 + k1 r^2) turns back at r = 1 / sqrt(-3 k1) = 1.069
  const PinholeCamera lens(folding);
  EXPECT_TRUE(lens.Project({1.06, 0.0, 1.0}).has_value());
  EXPECT_FALSE(lens.Project({1.08, 0.0, 1.0}).has_value());
}

TEST(PinholeCamera, UnprojectsFiniteRaysFarOutsideTheImage) {
  PinholeParameters folding = EurocParameters();
  folding.k2 = 0;
  test::ExpectFiniteRaysFarOutside(PinholeCamera(folding));
  test::ExpectFiniteRaysFarOutside(PinholeCamera(EurocParameters()));
}

TEST(PinholeCamera, ScalingKeepsPixelCentres) {
  test::ExpectScaledKeepsRays(PinholeCamera(EurocParameters()));
  EXPECT_NEAR(PinholeCamera(EurocParameters()).Scaled(0.5)->FocalLength(), 230.475, 1e-9);
}

TEST(PinholeCamera, RefusesImpossibleParameters) {
  PinholeParameters p = EurocParameters();
  p.fx = 0;
  EXPECT_THROW(PinholeCamera{p}, CheckError);
  p = EurocParameters();
  p.k1 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(PinholeCamera{p}, CheckError);
  p = EurocParameters();
  p.width = 0;
  EXPECT_THROW(PinholeCamera{p}, CheckError);
}

}  // namespace
}  // namespace deja_view
