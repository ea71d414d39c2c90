#include "deja_view/views/seen_surface.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>

#include "room_renderer.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const PinholeCamera kSmall(PinholeParameters{80, 60, 50, 50, 39.5, 29.5, 0, 0, 0, 0});

SeenSurface SeeRoom(const Rigid3& T_N_C, double relative_sigma = 0.01) {
  return SeeSurface(
      RoomRenderer(relative_sigma).Render(kSmall, T_N_C, {}), kSmall, T_N_C, GateOptions(), 4);
}

Rigid3 At(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), {x, y, z}};
}

TEST(SeenSurfaceTest, HasTheCertainPointsOfTheGrid) {
  const SeenSurface seen = SeeRoom(At(0.5, 0, 0));
  EXPECT_EQ(seen.pixels, 20 * 15);
  ASSERT_EQ(seen.points_N.size(), 300U);
  for (const Eigen::Vector3d& p_N : seen.points_N) {
    // On a wall of the room.
    EXPECT_NEAR(std::max({p_N.x() / 4, p_N.y() / 3, p_N.z() / 2}), 1, 1e-6);
  }
  const SeenSurface unsure = SeeRoom(At(0.5, 0, 0), 0.2);
  EXPECT_EQ(unsure.pixels, 300);
  EXPECT_TRUE(unsure.points_N.empty());
  EXPECT_EQ(SameLook(unsure, seen, kSmall, {}), 0.0);
}

TEST(SeenSurfaceTest, LooksTheSameFromTheSamePose) {
  EXPECT_NEAR(SameLook(SeeRoom({}), SeeRoom({}), kSmall, {}), 1, 1e-6);
}

TEST(SeenSurfaceTest, WeighsAnglesAndZoomByHand) {
  // One point, 1 m ahead of the query; known from 1.5 m behind it, and from beside it.
  SeenSurface query;
  query.points_N = {{0, 0, 1}};
  query.pixels = 2;  // the other is not certain
  SeenSurface known;
  known.T_N_C = At(0, 0, -0.5);
  known.depth = cv::Mat(60, 80, CV_32FC1, cv::Scalar(1.5));
  const SameLookOptions options{20, 1.4};
  const double zoom = std::log(1.5) / std::log(1.4);
  EXPECT_NEAR(SameLook(query, known, kSmall, options), 0.5 * std::exp(-zoom * zoom), 1e-9);
  known.T_N_C = At(0.5, 0, 0);
  known.depth.setTo(std::sqrt(1.25));
  const double angle = std::atan(0.5) * 180 / M_PI / 20;
  const double beside = std::log(std::sqrt(1.25)) / std::log(1.4);
  EXPECT_NEAR(SameLook(query, known, kSmall, options),
              0.5 * std::exp(-angle * angle - beside * beside),
              1e-9);
}

TEST(SeenSurfaceTest, WhatIsHiddenOrOutsideIsNotShown) {
  SeenSurface query;
  query.points_N = {{0, 0, 2}};
  query.pixels = 1;
  SeenSurface known;
  known.depth = cv::Mat(60, 80, CV_32FC1, cv::Scalar(2.1));
  EXPECT_NEAR(SameLook(query, known, kSmall, {}), 1, 1e-9);
  for (const double other : {1.5, 2.5, 0.0}) {  // before it, behind it, unknown
    known.depth.setTo(other);
    EXPECT_EQ(SameLook(query, known, kSmall, {}), 0.0) << other;
  }
  known.depth.setTo(2.0);
  known.T_N_C = {ExpSo3({0, M_PI, 0}), Eigen::Vector3d::Zero()};
  EXPECT_EQ(SameLook(query, known, kSmall, {}), 0.0);
  known.T_N_C = {ExpSo3({0, 0.8, 0}), Eigen::Vector3d::Zero()};
  EXPECT_EQ(SameLook(query, known, kSmall, {}), 0.0);
}

TEST(SeenSurfaceTest, FallsWithDistance) {
  double last = 1;
  for (const double x : {0.2, 0.5, 1.0, 2.0}) {
    const double look = SameLook(SeeRoom(At(x, 0, 0)), SeeRoom({}), kSmall, {});
    EXPECT_LT(look, last);
    last = look;
  }
  EXPECT_LT(last, 0.2);
}

TEST(SeenSurfaceTest, OptionsNameWhatIsWrong) {
  EXPECT_THAT((SameLookOptions{0, 1}.Validate()),
              ElementsAre(HasSubstr("angle_deg: 0"), HasSubstr("zoom: 1")));
}

}  // namespace
}  // namespace deja_view
