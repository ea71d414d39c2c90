#include "deja_view/lab/sim/scene.hpp"

#include "scene_builders.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

Scene SceneOf(const Surface& surface) {
  Scene scene;
  scene.surfaces.push_back(surface);
  return scene;
}

TEST(CastRay, MeetsAPlaneWhereGeometrySays) {
  const Scene scene = SceneOf(MakeSquare({0, 0, 5}, -Vector3f::UnitZ(), 4));
  const Vector3d direction = Vector3d(0.1, -0.2, 1).normalized();
  const auto hit = CastRay(scene, Vector3d::Zero(), direction);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range, 5 / direction.z(), 1e-5);
  EXPECT_LT(
      (scene.surfaces[0].Point(hit->u, hit->v) - (hit->range * direction).cast<float>()).norm(),
      1e-5);
}

TEST(CastRay, SeesTheFrontOnlyAndEndsAtTheEdge) {
  const Scene scene = SceneOf(MakeSquare({0, 0, 5}, -Vector3f::UnitZ(), 2));
  EXPECT_FALSE(CastRay(scene, {0, 0, 10}, -Vector3d::UnitZ()));
  EXPECT_TRUE(CastRay(scene, {0.99, 0.99, 0}, Vector3d::UnitZ()));
  EXPECT_FALSE(CastRay(scene, {1.01, 0, 0}, Vector3d::UnitZ()));
  EXPECT_FALSE(CastRay(scene, {0, 0, 6}, Vector3d::UnitZ()));
}

TEST(CastRay, ADiscHasNoCorners) {
  Surface disc = MakeSquare({0, 0, 5}, -Vector3f::UnitZ(), 2);
  disc.shape = Shape::kDisc;
  const Scene scene = SceneOf(disc);
  EXPECT_TRUE(CastRay(scene, {0.7, 0.7, 0}, Vector3d::UnitZ()));
  EXPECT_FALSE(CastRay(scene, {0.72, 0.72, 0}, Vector3d::UnitZ()));
}

TEST(CastRay, MeetsACylinder) {
  const Scene scene = SceneOf(MakeCylinder({5, 0, -1}, Vector3f::UnitZ(), 0.5F, 2));
  const auto straight = CastRay(scene, Vector3d::Zero(), Vector3d::UnitX());
  ASSERT_TRUE(straight);
  EXPECT_NEAR(straight->range, 4.5, 1e-6);
  EXPECT_NEAR(straight->v, 1.0, 1e-6);
  // Off the axis by 0.3 m: the chord begins 0.4 m before the middle.
  const auto aside = CastRay(scene, {0, 0.3, 0}, Vector3d::UnitX());
  ASSERT_TRUE(aside);
  EXPECT_NEAR(aside->range, 4.6, 1e-6);
  EXPECT_NEAR(
      (scene.surfaces[0].Point(aside->u, aside->v) - Vector3f(4.6F, 0.3F, 0)).norm(), 0, 1e-5);
  EXPECT_FALSE(CastRay(scene, {0, 0.51, 0}, Vector3d::UnitX()));
  EXPECT_FALSE(CastRay(scene, {0, 0, 1.01}, Vector3d::UnitX()));
}

TEST(CastRay, TakesTheNearest) {
  Scene scene = SceneOf(MakeSquare({0, 0, 5}, -Vector3f::UnitZ(), 2));
  scene.surfaces.push_back(MakeSquare({0, 0, 3}, -Vector3f::UnitZ(), 2));
  const auto hit = CastRay(scene, Vector3d::Zero(), Vector3d::UnitZ());
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->surface, 1);
}

}  // namespace
}  // namespace deja_view::sim
