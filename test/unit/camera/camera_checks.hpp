#pragma once

#include "deja_view/camera/camera.hpp"

#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view::test {

/// Point 0.5 to 10 m in front, up to 45 degrees off the axis in x and y.
inline Eigen::Vector3d RandomPointInFront(std::mt19937& rng) {
  std::uniform_real_distribution<double> slope(-1.0, 1.0);
  std::uniform_real_distribution<double> depth(0.5, 10.0);
  const double z = depth(rng);
  return {slope(rng) * z, slope(rng) * z, z};
}

/// Project(Unproject(pixel)) == pixel to 1e-9 px over the whole image, corners and centre included.
inline void ExpectRoundTrip(const Camera& camera) {
  const int steps = 24;
  for (int row = 0; row <= steps; ++row) {
    for (int column = 0; column <= steps; ++column) {
      const Eigen::Vector2d pixel((camera.width() - 1.0) * column / steps,
                                  (camera.height() - 1.0) * row / steps);
      const Eigen::Vector3d ray = camera.Unproject(pixel);
      EXPECT_NEAR(ray.norm(), 1.0, 1e-14);
      const auto back = camera.Project(3.7 * ray);
      ASSERT_TRUE(back.has_value()) << pixel.transpose();
      EXPECT_LT((*back - pixel).norm(), 1e-9) << pixel.transpose();
    }
  }
}

/// The analytic Jacobian agrees with central differences.
inline void ExpectJacobian(const Camera& camera) {
  std::mt19937 rng(3);
  for (int i = 0; i < 200; ++i) {
    Eigen::Vector3d p_C = RandomPointInFront(rng);
    if (i == 0) {
      p_C = {0.0, 0.0, 2.0};
    } else if (i == 1) {
      p_C = {1e-7, -2e-7, 2.0};
    }
    Camera::ProjectionJacobian J = Camera::ProjectionJacobian::Constant(1e30);
    ASSERT_TRUE(camera.Project(p_C, &J).has_value());
    const double step = 1e-5;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d delta = step * Eigen::Vector3d::Unit(k);
      const Eigen::Vector2d numeric =
          (*camera.Project(p_C + delta) - *camera.Project(p_C - delta)) / (2 * step);
      EXPECT_LT((numeric - J.col(k)).norm(), 1e-5 * (1.0 + J.norm())) << p_C.transpose();
    }
  }
}

/// Project gives what a function of OpenCV does, to 1e-9 px.
inline void ExpectProjectsAs(const Camera& camera,
                             const std::function<void(const std::vector<cv::Point3d>& points_C,
                                                      std::vector<cv::Point2d>* pixels)>& project) {
  std::mt19937 rng(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p_C = RandomPointInFront(rng);
    const auto pixel = camera.Project(p_C);
    ASSERT_TRUE(pixel.has_value());
    std::vector<cv::Point2d> expected;
    project({{p_C.x(), p_C.y(), p_C.z()}}, &expected);
    EXPECT_NEAR(pixel->x(), expected.at(0).x, 1e-9) << p_C.transpose();
    EXPECT_NEAR(pixel->y(), expected.at(0).y, 1e-9) << p_C.transpose();
  }
}

inline void ExpectFiniteRaysFarOutside(const Camera& camera) {
  for (const double x : {-1e9, -5000.0, -100.0, 3000.0, 1e6}) {
    for (const double y : {-1e7, 240.0, 9000.0}) {
      const Eigen::Vector3d ray = camera.Unproject({x, y});
      ASSERT_TRUE(ray.allFinite()) << x << " " << y;
      EXPECT_NEAR(ray.norm(), 1.0, 1e-12) << x << " " << y;
    }
  }
}

/// The half-size camera sees the same thing at (u + 0.5) / 2 - 0.5.
inline void ExpectScaledKeepsRays(const Camera& camera) {
  const auto half = camera.Scaled(0.5);
  EXPECT_EQ(half->width(), camera.width() / 2);
  EXPECT_EQ(half->height(), camera.height() / 2);
  EXPECT_EQ(half->ModelType(), camera.ModelType());
  std::mt19937 rng(4);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p_C = RandomPointInFront(rng);
    const Eigen::Vector2d expected =
        ((*camera.Project(p_C)).array() + 0.5).matrix() * 0.5 - Eigen::Vector2d::Constant(0.5);
    EXPECT_LT((*half->Project(p_C) - expected).norm(), 1e-9);
  }
}

}  // namespace deja_view::test
